"""Rollout, ship and corner from end to end on hand-made shards, with models that were trained for seconds."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pyarrow.parquet as pq
import pytest

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.generators.base import Settings
from drivegen.rollout.shipping import sample_id
from drivegen.store.draw import draw_scenes
from drivegen.store.rejected import read_rejected
from drivegen.store.results import WHOLE_SCENE
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import read_shard, write_shard
from drivegen.training import weights
from drivegen.warehouse.runs import read_scores
from stages import additions, corner, goals, rollout, rollout_baseline, ship
from stages._door import read_params
from tests.models import two_lanes
from tests.scenes import busy_crossing, noisy_samples

SHARDS = ("shard-00000.parquet", "shard-00001.parquet")
ENDS = ("parquet", "json")


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory, models: Path) -> Path:
    """Three test scenes in two shards, and the goals that two selectors recorded for them."""
    root = tmp_path_factory.mktemp("rollout")
    write_shard(root / "test" / SHARDS[0], [busy_crossing(101, "a"), two_lanes(9.0, "b")])
    write_shard(root / "test" / SHARDS[1], [busy_crossing(101, "c")])
    params = replace(read_params("goals", goals.Params), workers=1)
    for selector in ("learned", "random"):
        files = (root / f"{selector}.{end}" for end in ENDS)
        goals.main(params, root / "test", models / "selector", root / "goals" / selector, *files)
    return root


def quick(generation: Settings) -> Settings:
    return replace(generation, rollout=replace(generation.rollout, attempts=2, rounds=3))


def generated(root: Path, models: Path, method: str, out: str = "generated", **changes: int) -> list[Path]:
    """The shards of a method; what was turned down is in a file beside their folder."""
    params = read_params("rollout", rollout.Params)
    params = replace(params, workers=1, samples=2, generation=quick(params.generation))
    places = [root / "test", models, root / "goals", root / out / method, root / out / f"{method}.parquet"]
    rollout.main(replace(params, **changes), *places)
    return sorted((root / out / method).iterdir())


def continued(root: Path, models: Path, method: str) -> list[Path]:
    """What stage rollout_baseline leaves."""
    rollout_baseline.main(
        rollout_baseline.Params(sampling_seed=7, workers=1, samples=2), root / "test", models, root / "plain" / method
    )
    return sorted((root / "plain" / method).iterdir())


def test_additions_are_scored_beside_the_futures_as_they_are(root: Path, models: Path) -> None:
    generated(root, models, "drivegen_alone")
    files = [root / f"additions/drivegen_alone.{end}" for end in ("parquet", "json")]
    params = replace(read_params("additions", additions.Params), workers=1)
    additions.main(params, root / "test", models, root / "generated/drivegen_alone", *files)
    scenarios, values = read_scores([files[0]])
    assert scenarios == ("a", "b", "c")
    means = orjson.loads(files[1].read_bytes())
    assert means["tempo/mean_sade"] == pytest.approx(means["none/mean_sade"])
    assert means["checker+tempo/illegal_per_vehicle"] <= means["none/illegal_per_vehicle"]
    assert values.keys() == means.keys()


def test_means_of_additions_are_over_the_scenarios_that_are_as_long_as_most(models: Path, tmp_path: Path) -> None:
    scenes = [busy_crossing(41, "a"), busy_crossing(31, "b"), busy_crossing(41, "c")]
    write_shard(tmp_path / "test" / SHARDS[0], scenes)
    write_samples(tmp_path / "bits" / SHARDS[0], [noisy_samples(scene, 2, method="bits") for scene in scenes])
    params = replace(read_params("additions", additions.Params), workers=1)
    additions.main(params, tmp_path / "test", models, tmp_path / "bits", tmp_path / "a.parquet", tmp_path / "a.json")
    _, values = read_scores([tmp_path / "a.parquet"])
    means = orjson.loads((tmp_path / "a.json").read_bytes())
    assert values["steps"].tolist() == [[41, 31, 41]]
    assert means == {name: pytest.approx(column[0, [0, 2]].mean()) for name, column in values.items()}


def test_additions_are_scored_to_the_scenarios_that_the_futures_are_of_or_not_at_all(
    root: Path, models: Path, tmp_path: Path
) -> None:
    generated(root, models, "drivegen_alone")
    for shard in SHARDS:
        write_samples(tmp_path / "other" / shard, read_samples(root / "generated/drivegen_alone" / shard)[::-1])
    params = replace(read_params("additions", additions.Params), workers=1)
    with pytest.raises(UnusableInput, match="futures of other scenarios"):
        additions.main(params, root / "test", models, tmp_path / "other", tmp_path / "a.parquet", tmp_path / "a.json")


def test_what_follows_goals_and_what_does_not_have_stages_of_their_own(root: Path, models: Path) -> None:
    with pytest.raises(UnusableInput, match=r"run\.own"):
        continued(root, models, "drivegen")
    with pytest.raises(UnusableInput, match=r"run\.baselines"):
        generated(root, models, "log")


@pytest.mark.parametrize("method", ["log", "constant_velocity", "drivegen", "drivegen_without_goals"])
def test_every_method_leaves_a_shard_beside_each_test_shard(root: Path, models: Path, method: str) -> None:
    files = (generated if method.startswith("drivegen") else continued)(root, models, method)
    assert [f.name for f in files] == list(SHARDS)
    for file in files:
        scenes = read_shard(root / "test" / file.name)
        for scene, samples in zip(scenes, read_samples(file), strict=True):
            assert samples.scenario_id == scene.scenario_id
            assert samples.method == method
            assert samples.motion.valid.shape == (2, len(scene.vehicles), scene.steps)
            assert not samples.dropped.any()
            np.testing.assert_array_equal(samples.first_violation >= 0, samples.violation != 0)


def test_rollout_gives_the_same_bytes_again_and_its_goals_are_those_recorded(root: Path, models: Path) -> None:
    first, again = generated(root, models, "drivegen"), generated(root, models, "drivegen", "again")
    assert [f.read_bytes() for f in first] == [f.read_bytes() for f in again]
    (root / "goals" / "random").rename(root / "goals" / "hidden")
    try:
        with pytest.raises(MissingTool, match="goals stage"):
            generated(root, models, "drivegen_without_goals", "none")
    finally:
        (root / "goals" / "hidden").rename(root / "goals" / "random")


def test_what_was_turned_down_is_kept_of_the_scenes_that_pictures_draw_and_changes_no_sample(root: Path, models: Path) -> None:
    method = "drivegen_without_goals"  # goals at random: much is turned down
    shards = {}
    for out, changes in (("none", {"rejected": 0}), ("two", {"rejected": 2}), ("spread", {"rejected": 2, "workers": 2})):
        shards[out] = [file.read_bytes() for file in generated(root, models, method, out, **changes)]
    assert shards["none"] == shards["two"] == shards["spread"]
    files = [root / out / f"{method}.parquet" for out in shards]
    assert files[1].read_bytes() == files[2].read_bytes()
    assert read_rejected(files[0]) == []
    found = read_rejected(files[1])
    drawn = draw_scenes(7, root / "test", root / "two" / method, 2)
    assert [one.scenario_id for one in found] == [one.scenario.scenario_id for one in drawn]
    assert sum(map(len, found)) > 0
    for one, scene in zip(found, drawn, strict=True):
        assert one.method == method
        assert len(one) == int((scene.samples.attempts - 1).sum())
        assert one.violation.all()


def test_a_planner_of_whose_weights_one_is_no_number_ships_nothing(
    root: Path, models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sealed as if it were whole: the checksum is right, the number is not."""
    broken, folder = tmp_path / "models", tmp_path / "models" / "planners" / "route_fm"
    shutil.copytree(models, broken)
    settings, tensors = weights.read_weights(folder, "planner", "route_fm")
    name = min(tensors)
    tensors[name] = np.where(np.arange(tensors[name].size).reshape(tensors[name].shape) == 0, np.nan, tensors[name])
    with monkeypatch.context() as patch:
        patch.setattr(weights, "check_finite", lambda *_: None)
        weights.write_weights(folder, "planner", "route_fm", settings, tensors)
    params = replace(read_params("ship", ship.Params), workers=1)
    with pytest.raises(UnusableInput, match=rf"route_fm/weights\.safetensors: {name} has a number that is not finite"):
        ship.main(params, root / "test", broken, tmp_path / "shipped", *(tmp_path / f"shipped.{end}" for end in ENDS))
    assert [path.name for path in tmp_path.iterdir()] == ["models"]


def test_ship_lets_out_legal_scenarios_and_counts_everything(root: Path, models: Path, tmp_path: Path) -> None:
    for shard in SHARDS:
        write_shard(tmp_path / "new" / shard, [replace(s, log=None) for s in read_shard(root / "test" / shard)])
    params = read_params("ship", ship.Params)
    params = replace(params, workers=1, generation=quick(params.generation), settings=replace(params.settings, fewest=2))
    for out in ("shipped", "again"):
        ship.main(params, tmp_path / "new", models, tmp_path / out, *(tmp_path / f"{out}.{end}" for end in ENDS))
    [read] = set(pq.read_table(tmp_path / "shipped.parquet")["inputs"].to_pylist())
    used = ("planners/route_fm", "selector", "limits.json")
    assert read.split() == [str(place) for place in (tmp_path / "new", *(models / name for name in used))]
    counts = orjson.loads((tmp_path / "shipped.json").read_bytes())
    assert counts["asked"] == 3 * params.samples
    assert counts["asked"] == counts.get("shipped", 0) + sum(n for name, n in counts.items() if name.startswith("rejected."))
    shipped = [scene for shard in SHARDS for scene in read_shard(tmp_path / "shipped" / shard)]
    assert len(shipped) == counts["shipped"] > 0
    assert sum(len(scene.vehicles) for scene in shipped) == counts["vehicles.shipped"]
    rows = pq.read_table(tmp_path / "shipped.parquet").to_pylist()
    kept = {sample_id(row["scenario"], row["sample"]) for row in rows if row["metric"] == "shipped" and row["value"]}
    assert kept == {scene.scenario_id for scene in shipped}
    assert len([row for row in rows if row["metric"].startswith("rejected.")]) == counts["asked"] - counts["shipped"]
    for scene in shipped:
        scene.validate()
        assert scene.log is not None
        assert scene.log.valid.all()
    for shard in SHARDS:
        assert (tmp_path / "shipped" / shard).read_bytes() == (tmp_path / "again" / shard).read_bytes()


def played(root: Path, models: Path, out: Path, rounds: int, strength: float | None = None) -> list[Path]:
    """The folders of a chain of rounds."""
    params = read_params("corner", corner.Params)
    pressure = params.pressure if strength is None else replace(params.pressure, strength=strength)
    params = replace(
        params, workers=1, samples=3, draws=20, prior_strength=1.0, generation=quick(params.generation), pressure=pressure
    )
    for number in range(rounds):
        files = (out / f"{number}.{end}" for end in ENDS)
        corner.main(params, root / "test", models, root / "goals" / "learned", out / str(number), *files)
    return [out / str(number) for number in range(rounds)]


@pytest.fixture(scope="module")
def rounds(root: Path, models: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return played(root, models, tmp_path_factory.mktemp("corner"), 2)


def test_the_first_round_is_traffic_as_it_is_and_the_second_leans(rounds: list[Path]) -> None:
    for number, folder in enumerate(rounds):
        samples = [s for shard in SHARDS for s in read_samples(folder / "samples" / shard)]
        leaned = any(not np.allclose(s.used, s.natural) for s in samples)
        assert leaned == (number > 0)
        for s in samples:
            np.testing.assert_allclose(s.used[:, 0], s.natural[:, 0], rtol=1e-5)  # the target is left alone


def test_a_rounds_numbers_are_those_that_the_report_and_the_flow_read(rounds: list[Path]) -> None:
    from flows.iterate import GAIN

    for number, folder in enumerate(rounds):
        metrics = orjson.loads((folder.parent / f"{number}.json").read_bytes())
        assert (metrics["round"], metrics["scenarios"], metrics["runs"]) == (number, 3, 9)
        assert 0.0 <= metrics[GAIN] <= 1.0  # what the flow `iterate` goes on by
        for name in ("collision", "distance", "spread_over_runs", "social_illegal", "log_ratio", "min_sade", "mean_sade"):
            assert metrics[f"{name}.low"] <= metrics[name] + 1e-9
            assert metrics[name] <= metrics[f"{name}.high"] + 1e-9
        assert metrics["comfort_absolute"] > 0
        assert metrics["collision.at_fault"] <= metrics["collision"]
        assert metrics["distance"] > 10
    assert orjson.loads((rounds[0].parent / "0.json").read_bytes())["log_ratio"] == 0


def test_every_run_of_a_round_is_in_the_record_and_its_means_are_the_rounds(rounds: list[Path]) -> None:
    for number, folder in enumerate(rounds):
        numbers = orjson.loads((folder.parent / f"{number}.json").read_bytes())
        rows = pq.read_table(folder.parent / f"{number}.parquet").to_pylist()
        assert {(row["stage"], row["item"], row["driver"]) for row in rows} == {("corner", str(number), "idm")}
        runs = {(row["scenario"], row["sample"], row["metric"]): row["value"] for row in rows if row["sample"] != WHOLE_SCENE}
        assert {sample for _, sample, _ in runs} == {0, 1, 2}
        for name in ("collision", "collision.counted", "distance", "left_map"):
            values = [value for (_, _, metric), value in runs.items() if metric == name]
            assert len(values) == 9
            assert np.mean(values) == pytest.approx(numbers[name])
        hits = {(scene, k) for (scene, k, metric), value in runs.items() if metric == "collision" and value}
        assert hits == {(scene, k) for scene, k, metric in runs if metric.startswith("impact.kind.")}
        assert hits == {(scene, k) for scene, k, metric in runs if metric == "impact.partner"}


def test_knowledge_is_pooled_over_rounds(rounds: list[Path]) -> None:
    seen = [np.sum(orjson.loads((folder / "knowledge.json").read_bytes())["encounters"]) for folder in rounds]
    assert 0 < seen[0] < seen[1]


def test_the_driven_target_is_kept_beside_the_traffic_it_met(rounds: list[Path]) -> None:
    for shard in SHARDS:
        driven, traffic = (read_samples(rounds[0] / part / shard) for part in ("driven", "samples"))
        for one, all_ in zip(driven, traffic, strict=True):
            assert one.motion.valid.shape[:2] == (3, 1)
            np.testing.assert_allclose(one.motion.position[:, 0, 0], all_.motion.position[:, 0, 0], atol=1e-4)


def test_a_chain_of_rounds_gives_the_same_bytes_again(root: Path, models: Path, rounds: list[Path], tmp_path: Path) -> None:
    for one, other in zip(rounds, played(root, models, tmp_path, 2), strict=True):
        files = sorted(f.relative_to(one) for f in one.rglob("*") if f.is_file())
        assert files
        for file in files:
            assert (one / file).read_bytes() == (other / file).read_bytes()


def test_without_strength_nothing_is_leaned_on(root: Path, models: Path, tmp_path: Path) -> None:
    last = played(root, models, tmp_path, 2, strength=0.0)[-1]
    for shard in SHARDS:
        for samples in read_samples(last / "samples" / shard):
            np.testing.assert_allclose(samples.used, samples.natural, rtol=1e-5)


def test_a_round_without_the_one_before_names_it(root: Path, models: Path, tmp_path: Path) -> None:
    params = replace(read_params("corner", corner.Params), workers=1)
    files = [tmp_path / f"1.{end}" for end in ENDS]
    with pytest.raises(MissingTool, match="corner@0"):
        corner.main(params, root / "test", models, root / "goals" / "learned", tmp_path / "1", *files)
