"""Stage train_planner writes model, metrics and loss curve, the same bytes every time."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from drivegen.checker.verdicts import write_limits_file
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.store.scenarios import write_shard
from stages import train_planner
from stages._door import read_params
from tests.checking import LIMITS
from tests.scenes import crossing, drive, joined, scenario, stack

ROOT = Path(__file__).parents[2]


@pytest.fixture
def params(tmp_path: Path) -> train_planner.Params:
    """The project's own parameters with a tiny budget."""
    tree = yaml.safe_load((ROOT / "params.yaml").read_text())
    settings = tree["train_planner"]["planners"]["route_fm"]
    settings |= {"width": 16, "blocks": 1, "along": 4, "across": 2}
    settings["training"] |= {"steps": 4, "batch": 8, "report_every": 2, "checkpoint_every": 2}
    tree["train_planner"] |= {"planners": {"route_fm": settings}, "samples": 2}
    tree["run"]["workers"] = 1
    (tmp_path / "params.yaml").write_text(yaml.safe_dump(tree))
    return read_params("train_planner", train_planner.Params, tmp_path / "params.yaml")


@pytest.fixture
def limits(tmp_path: Path) -> Path:
    """The checker's limits as the calibrate stage writes them."""
    write_limits_file(tmp_path / "limits.json", LIMITS)
    return tmp_path / "limits.json"


@pytest.fixture
def scenarios(tmp_path: Path) -> Path:
    """Two small splits on a crossing."""
    random, roads = np.random.default_rng(0), crossing()
    for split, count in (("train", 6), ("val", 2)):
        scenes = []
        for k in range(count):
            ways = [(0, 8, 4), (0, 9, 5), (2, 15, 7)]
            cars = [drive(joined(roads, *way), random.uniform(2, 40), random.uniform(5, 11), 101) for way in ways]
            scenes.append(scenario(roads, stack(cars), f"{split}-{k}"))
        write_shard(tmp_path / "scenarios" / split / "shard-00000.parquet", scenes)
    return tmp_path / "scenarios"


def test_it_writes_model_metrics_and_curve_with_the_same_bytes(
    params: train_planner.Params, scenarios: Path, limits: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for run in ("a", "b"):
        train_planner.main(
            params, scenarios, limits, tmp_path / run / "route_fm", tmp_path / run / "metrics.json", tmp_path / run / "curve.csv"
        )
    for file in ("route_fm/weights.safetensors", "route_fm/settings.json", "metrics.json", "curve.csv"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    metrics = json.loads((tmp_path / "a" / "metrics.json").read_text())
    assert metrics["train_tracks"] == 18
    assert metrics["scored_tracks"] == 6
    assert 0 < metrics["ade_best"] <= metrics["ade_mean"] < 30
    assert metrics["goal_error"] < 1e-3
    assert metrics["miss_rate"] == 0
    assert 0 < metrics["hidden.ade_best"] < 30
    assert metrics["hidden.ade_best"] != metrics["ade_best"]
    assert 0 < metrics["base.ade_best"] == metrics["base.ade_mean"] < 30
    assert metrics["log.jerk_distance"] == 0 < metrics["jerk_distance"]
    assert 0 <= metrics["off_road"] <= metrics["illegal"] <= 1
    assert 0 <= metrics["log.off_road"] <= metrics["log.illegal"] <= 1
    first, *rows = (tmp_path / "a" / "curve.csv").read_text().splitlines()
    assert first == "step,train,validation,ade"
    assert [0 < float(row.split(",")[3]) < 30 for row in rows] == [True, True]
    assert not list((tmp_path / ".drivegen" / "checkpoints").glob("*/*"))


def test_times_of_training_and_planning_are_costs_and_no_results(
    params: train_planner.Params, scenarios: Path, limits: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    rest = (tmp_path / "route_fm", tmp_path / "metrics.json", tmp_path / "curve.csv")
    costs = train_planner.main(params, scenarios, limits, *rest)
    assert costs["planned"] == 24  # six tracks, two samples, with and without routes
    assert costs["training_cpu_seconds"] > 0 < costs["planning_cpu_seconds"]
    assert "seconds" not in rest[1].read_text()


def test_a_slow_planner_is_scored_on_the_tracks_of_few_scenes(
    params: train_planner.Params, scenarios: Path, limits: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    few = replace(params, scored_scenes={"route_fm": 1})
    train_planner.main(few, scenarios, limits, tmp_path / "route_fm", tmp_path / "metrics.json", tmp_path / "curve.csv")
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert (metrics["scored_scenes"], metrics["scored_tracks"]) == (1, 3)


def test_a_rate_at_which_the_loss_explodes_is_one_sentence_and_leaves_no_weights(
    params: train_planner.Params, scenarios: Path, limits: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    settings = params.planners["route_fm"]
    absurd = settings | {"training": settings["training"] | {"learning_rate": 1e4, "warmup": 0, "steps": 40}}
    rest = (tmp_path / "made" / "route_fm", tmp_path / "metrics.json", tmp_path / "curve.csv")
    with pytest.raises(UnusableInput, match=r"the loss is (nan|inf) at step \d+ of 40; lower learning_rate \(10000\)"):
        train_planner.main(replace(params, planners={"route_fm": absurd}), scenarios, limits, *rest)
    assert not any(path.exists() for path in rest)


def test_unknown_planners_missing_settings_missing_scenarios_and_missing_limits_are_named(
    params: train_planner.Params, scenarios: Path, limits: Path, tmp_path: Path
) -> None:
    rest = (tmp_path / "m.json", tmp_path / "c.csv")
    with pytest.raises(UnusableInput, match="no planners plugin is called 'guess'"):
        train_planner.main(params, scenarios, limits, tmp_path / "guess", *rest)
    with pytest.raises(UnusableInput, match="no settings for 'paper'"):
        train_planner.main(params, scenarios, limits, tmp_path / "paper", *rest)
    with pytest.raises(MissingTool, match="ingest"):
        train_planner.main(params, tmp_path / "nowhere", limits, tmp_path / "route_fm", *rest)
    with pytest.raises(MissingTool, match="calibrate"):
        train_planner.main(params, scenarios, tmp_path / "nowhere.json", tmp_path / "route_fm", *rest)
