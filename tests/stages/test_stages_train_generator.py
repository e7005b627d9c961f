"""Stages train_generator and rollout_rival: the same bytes every time, and errors that name the remedy."""

import json
from pathlib import Path

import pytest
import yaml

from drivegen.checker.verdicts import write_limits_file
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.generators.shared.learned import Learned
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import write_shard
from stages import rollout_rival, train_generator
from stages._door import read_params
from tests.checking import LIMITS
from tests.models import two_lanes
from tests.scenes import busy_crossing

ROOT = Path(__file__).parents[2]
FILES = ("generators/lctgen/weights.safetensors", "generators/lctgen/settings.json", "metrics.json", "curve.csv")


@pytest.fixture
def params(tmp_path: Path) -> train_generator.Params:
    """The project's own parameters with a tiny budget."""
    tree = yaml.safe_load((ROOT / "params.yaml").read_text())
    settings = tree["train_generator"]["generators"]["lctgen"]
    settings |= {"width": 16, "heads": 2, "layers": 1, "blocks": 1, "modes": 3}
    settings["training"] |= {"steps": 4, "batch": 4, "report_every": 2, "checkpoint_every": 2}
    tree["train_generator"] |= {"generators": {"lctgen": settings}, "samples": 2}
    tree["run"]["workers"] = 1
    (tmp_path / "params.yaml").write_text(yaml.safe_dump(tree))
    return read_params("train_generator", train_generator.Params, tmp_path / "params.yaml")


@pytest.fixture
def scenarios(tmp_path: Path) -> Path:
    """Two small splits."""
    for split, speeds in (("train", (4.0, 8.0, 12.0)), ("val", (6.0,))):
        scenes = [busy_crossing(101, f"{split}-crossing"), *(two_lanes(speed) for speed in speeds)]
        write_shard(tmp_path / "scenarios" / split / "shard-00000.parquet", scenes)
    return tmp_path / "scenarios"


def test_it_writes_model_metrics_and_curve_with_the_same_bytes(
    params: train_generator.Params, scenarios: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for run in ("a", "b"):
        out = tmp_path / run
        costs = train_generator.main(params, scenarios, out / "generators/lctgen", out / "metrics.json", out / "curve.csv")
    assert costs["training_cpu_seconds"] > 0
    for file in FILES:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    metrics = json.loads((tmp_path / "a" / "metrics.json").read_text())
    assert (metrics["train_examples"], metrics["validation_examples"], metrics["steps"]) == (8, 4, 4)  # every log and its twin
    assert metrics["parameters"] > 1000
    assert 0 < metrics["validation_min_sade"] <= metrics["validation_mean_sade"]
    assert "lctgen_log_code.validation_min_sade" in metrics
    counted = ("min_sade", "mean_sade", "energy_joint")
    tried = {float(text): sum(errors[name] for name in counted) for text, errors in metrics["tried"].items()}
    assert set(tried) == set(params.temperatures)
    assert len(set(tried.values())) > 1
    assert metrics["sampling_temperature"] == min(tried, key=tried.__getitem__)
    assert [line.split(",")[0] for line in (tmp_path / "a" / "curve.csv").read_text().splitlines()] == ["step", "2", "4"]
    assert not list((tmp_path / ".drivegen" / "checkpoints").glob("*/*"))


def test_a_run_that_was_killed_while_temperatures_were_tried_goes_on_to_the_same_bytes(
    params: train_generator.Params, scenarios: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    a, b = ((tmp_path / run / FILES[0]).parent for run in "ab")
    train_generator.main(params, scenarios, a, tmp_path / "a/metrics.json", tmp_path / "a/curve.csv")
    with monkeypatch.context() as patched:
        patched.setattr(Learned, "tune", killed)
        with pytest.raises(KeyboardInterrupt):
            train_generator.main(params, scenarios, b, tmp_path / "b/metrics.json", tmp_path / "b/curve.csv")
    assert list((tmp_path / ".drivegen" / "checkpoints").glob("*/*"))
    train_generator.main(params, scenarios, b, tmp_path / "b/metrics.json", tmp_path / "b/curve.csv")
    for file in FILES:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_a_rival_is_rolled_out_and_judged(
    params: train_generator.Params, scenarios: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    models = tmp_path / "models"
    train_generator.main(params, scenarios, models / "generators/lctgen", tmp_path / "metrics.json", tmp_path / "curve.csv")
    rolling = rollout_rival.Params(sampling_seed=7, workers=1, samples=3)
    with pytest.raises(MissingTool, match="calibrates"):
        rollout_rival.main(rolling, scenarios / "val", models, tmp_path / "generated" / "lctgen")
    write_limits_file(models / "limits.json", LIMITS)
    rollout_rival.main(rolling, scenarios / "val", models, tmp_path / "generated" / "lctgen")
    samples = read_samples(tmp_path / "generated" / "lctgen" / "shard-00000.parquet")
    assert [s.scenario_id for s in samples] == ["val-crossing", "taught-6"]
    assert {s.method for s in samples} == {"lctgen"}
    assert all(s.motion.valid.shape[0] == 3 for s in samples)


def test_what_does_not_learn_what_has_no_settings_and_what_is_missing_is_named(
    params: train_generator.Params, scenarios: Path, tmp_path: Path
) -> None:
    rest = (tmp_path / "m.json", tmp_path / "c.csv")
    with pytest.raises(UnusableInput, match="learns nothing"):
        train_generator.main(params, scenarios, tmp_path / "log", *rest)
    with pytest.raises(UnusableInput, match="no settings for 'scene_transformer'"):
        train_generator.main(params, scenarios, tmp_path / "scene_transformer", *rest)
    with pytest.raises(MissingTool, match="ingest"):
        train_generator.main(params, tmp_path / "nowhere", tmp_path / "lctgen", *rest)
