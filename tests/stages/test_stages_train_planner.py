"""Stage train_planner writes model, metrics and loss curve, the same bytes every time."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from drivegen.errors import MissingTool, UnusableInput
from drivegen.store.scenarios import write_shard
from stages import train_planner
from stages._door import read_params
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
    params: train_planner.Params, scenarios: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for run in ("a", "b"):
        train_planner.main(
            params, scenarios, tmp_path / run / "route_fm", tmp_path / run / "metrics.json", tmp_path / run / "curve.csv"
        )
    for file in ("route_fm/weights.safetensors", "route_fm/settings.json", "metrics.json", "curve.csv"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    metrics = json.loads((tmp_path / "a" / "metrics.json").read_text())
    assert metrics["train_tracks"] == 18
    assert metrics["scored_tracks"] == 6
    assert 0 < metrics["ade_best"] <= metrics["ade_mean"] < 30
    assert metrics["goal_error"] < 1e-3
    assert (tmp_path / "a" / "curve.csv").read_text().splitlines()[0] == "step,train,validation"
    assert not list((tmp_path / ".drivegen" / "checkpoints").glob("*/*"))


def test_unknown_planners_missing_settings_and_missing_scenarios_are_named(
    params: train_planner.Params, scenarios: Path, tmp_path: Path
) -> None:
    rest = (tmp_path / "m.json", tmp_path / "c.csv")
    with pytest.raises(UnusableInput, match="no planners plugin is called 'guess'"):
        train_planner.main(params, scenarios, tmp_path / "guess", *rest)
    with pytest.raises(UnusableInput, match="no settings for 'paper'"):
        train_planner.main(params, scenarios, tmp_path / "paper", *rest)
    with pytest.raises(MissingTool, match="ingest"):
        train_planner.main(params, tmp_path / "nowhere", tmp_path / "route_fm", *rest)
