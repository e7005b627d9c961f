import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from torch import nn

from drivegen.checker.limits import RULES
from drivegen.checker.verdicts import read_limits_file
from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.features import COUNT
from drivegen.drivers.shared.network import write_network
from drivegen.store.results import RESULT, WHOLE_SCENE
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import write_shard
from drivegen.world.outcome import CollisionKind
from stages import calibrate, drive
from stages._door import read_params
from tests.checking import LIMITS
from tests.scenes import busy_crossing, noisy_samples


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Train, validation and test scenes with samples of one method."""
    root = tmp_path_factory.mktemp("drive")
    for split, shard, ids in (("train", 0, "abcd"), ("val", 0, "ef"), ("test", 0, "gh"), ("test", 1, "i")):
        scenes = [busy_crossing(81, f"scene-{letter}") for letter in ids]
        write_shard(root / "scenarios" / split / f"shard-{shard:05}.parquet", scenes)
        if split == "test":
            noisy = [noisy_samples(scene, 3, seed=i) for i, scene in enumerate(scenes)]
            write_samples(root / "generated" / "drivegen" / f"shard-{shard:05}.parquet", noisy)
    return root


def driven(root, out, params):
    results, summary = (root / out / f"idm.{end}" for end in ("parquet", "json"))
    drive.main(
        params, root / "scenarios" / "test", root / "generated" / "drivegen", root / out / "runs.parquet", results, summary
    )
    return results, summary


@pytest.fixture(scope="module")
def params():
    return replace(read_params("drive", drive.Params), workers=1, draws=50)


@pytest.fixture(scope="module")
def once(made, params):
    """What the stage writes: results and summary, with the runs beside them."""
    return driven(made, "once", params)


def test_every_method_of_traffic_gets_rows_and_a_flat_summary(once):
    results, summary = once
    rows = pq.read_table(results)
    assert rows.schema.equals(RESULT)
    rows = rows.to_pylist()
    assert {row["method"] for row in rows} == {"log", "drivegen"}
    assert {row["driver"] for row in rows} == {"idm"}
    numbers = json.loads(summary.read_text())
    assert all(value is None or isinstance(value, int | float) for value in numbers.values())
    assert (numbers["log.scenarios"], numbers["log.runs"], numbers["drivegen.runs"]) == (3, 3, 9)
    for name in ("collision", "distance", "absolute_acceleration", "off_road"):
        values = [row["value"] for row in rows if row["metric"] == name and row["method"] == "drivegen" and row["sample"] < 0]
        assert numbers[f"drivegen.{name}"] == pytest.approx(np.mean(values))
        low, high = (numbers[f"drivegen.{name}.{end}"] for end in ("low", "high"))
        assert low - 1e-9 <= numbers[f"drivegen.{name}"] <= high + 1e-9
    assert numbers["drivegen.reactive.runs"] == 9
    assert numbers["drivegen.reactive.collision"] <= numbers["drivegen.collision"]
    assert numbers["drivegen.imposed_braking"] == 0 <= numbers["drivegen.reactive.imposed_braking"] <= 6
    assert {row["value"] >= 0 for row in rows if row["metric"] == "reactive.imposed_loss"} == {True}
    kinds = sum(numbers[f"drivegen.collision.{kind.name.lower()}"] for kind in CollisionKind if kind)
    assert kinds == pytest.approx(numbers["drivegen.collision"])
    assert numbers["log.spread_over_samples"] is None  # one run a scene
    assert numbers["drivegen.distance"] > 20


def test_runs_through_replayed_logs_are_kept_with_how_they_ended(once):
    results, _ = once
    runs = read_samples(results.with_name("runs.parquet"))
    rows = pq.read_table(results).to_pylist()
    ended = {
        row["scenario"]: row["value"]
        for row in rows
        if (row["metric"], row["method"], row["sample"]) == ("collision", "log", WHOLE_SCENE)
    }
    assert {run.scenario_id: float(not run.legal.all()) for run in runs} == ended
    assert all(run.motion.valid.shape == (1, 1, 81) and run.method == "idm" for run in runs)
    for run in runs:
        assert run.first_violation[0, 0] == (run.motion.last_valid()[0, 0] if ended[run.scenario_id] else -1)


def test_every_run_says_how_it_ended(once):
    rows = pq.read_table(once[0]).to_pylist()
    runs = {}
    for row in rows:
        if row["sample"] != WHOLE_SCENE:
            runs.setdefault((row["method"], row["scenario"], row["sample"]), {})[row["metric"]] = row["value"]
    assert sorted(k for method, scene, k in runs if (method, scene) == ("drivegen", "scene-h")) == [0, 1, 2]
    assert [k for method, scene, k in runs if (method, scene) == ("log", "scene-h")] == [0]
    for run in runs.values():
        kinds = [name for name in run if name.startswith("impact.kind.")]
        assert len(kinds) == run["collision"] == ("impact.step" in run) == ("impact.partner" in run)
    scene = [
        row["value"] for row in rows if (row["method"], row["scenario"], row["metric"]) == ("drivegen", "scene-h", "distance")
    ]
    assert np.mean(scene[1:]) == pytest.approx(scene[0])


def test_intervals_are_over_recordings(made, params, tmp_path):
    scenes = [busy_crossing(81, name) for name in ("a-000", "a-001", "b-000")]
    for recordings, names in ((2, [s.scenario_id for s in scenes]), (1, ["a-000", "a-001", "a-002"])):
        root = tmp_path / str(recordings)
        shard = [replace(scene, scenario_id=name) for scene, name in zip(scenes, names, strict=True)]
        write_shard(root / "scenarios/test/shard-00000.parquet", shard)
        write_samples(root / "generated/drivegen/shard-00000.parquet", [noisy_samples(s, 3, seed=i) for i, s in enumerate(shard)])
        results, summary = driven(root, "out", params)
        numbers = json.loads(summary.read_text())
        assert numbers["drivegen.recordings"] == recordings
        rows = pq.read_table(results).to_pylist()
        wanted = ("drivegen", "distance", WHOLE_SCENE)
        values = [row["value"] for row in rows if (row["method"], row["metric"], row["sample"]) == wanted]
        ends = [numbers[f"drivegen.distance.{end}"] for end in ("low", "high")]
        one_each = pytest.approx(sorted([np.mean(values[:2]), values[2]]))  # draws of one recording alone
        assert ends == (one_each if recordings == 2 else [None, None])
        assert (numbers["drivegen.spread_over_runs.low"] is None) == (recordings == 1)


def test_the_same_seed_gives_the_same_bytes(made, params, once):
    assert [file.read_bytes() for file in once] == [file.read_bytes() for file in driven(made, "again", params)]


def test_a_driver_without_settings_or_a_method_without_samples_is_named(made, params):
    with pytest.raises(UnusableInput, match=r"drive\.drivers has no settings for 'idm'"):
        driven(made, "none", replace(params, drivers={}))
    with pytest.raises(UnusableInput, match="unknown name 'haste'"):
        driven(made, "none", replace(params, drivers={"idm": {**params.drivers["idm"], "haste": 1.0}}))
    samples = noisy_samples(busy_crossing(81, "another"), 3)
    write_samples(made / "generated" / "odd" / "shard-00000.parquet", [samples])
    with pytest.raises(UnusableInput, match="other scenarios"):
        drive.main(
            params, made / "scenarios" / "test", made / "generated" / "odd",
            *(made / "x" / name for name in ("runs.parquet", "idm.parquet", "idm.json")),
        )  # fmt: skip
    assert not (made / "x").exists()


def test_calibrate_writes_limits_that_can_be_read_and_rates_of_both_splits(made):
    settings = calibrate.Params(workers=1, share=0.99, floors=LIMITS)
    calibrate.main(settings, made / "scenarios", made / "limits.json", made / "calibrate.json")
    limits = read_limits_file(made / "limits.json")
    assert limits.off_road >= LIMITS.off_road
    rates = json.loads((made / "calibrate.json").read_text())
    assert (rates["tracks"], rates["share"]) == (32, 0.99)
    assert all(rates["pass_rate"][rule] >= 0.99 for rule in RULES)
    assert rates["held_out"]["legal"] == 1.0


def test_calibrate_needs_train_logs(tmp_path):
    (tmp_path / "train").mkdir()
    with pytest.raises(UnusableInput, match="no scenario to calibrate"):
        calibrate.main(calibrate.Params(1, 0.99, LIMITS), tmp_path, tmp_path / "limits.json", tmp_path / "rates.json")
    assert not (tmp_path / "limits.json").exists()


def test_what_other_drivers_are_told_changes_no_byte_of_a_driver_s_results(made, params, once):
    others = {**params.drivers, "gail": {**params.drivers["gail"], "sees_rules": False}}
    before, _ = once
    after, _ = driven(made, "others", replace(params, drivers=others))
    assert after.read_bytes() == before.read_bytes()


def test_a_run_is_of_the_driver_s_weights(made, params, tmp_path):
    weights, runs = tmp_path / "weights", []
    learned = replace(params, drivers={"gail": {"weights": str(weights), "sees_rules": True}})
    out = [tmp_path / name for name in ("runs.parquet", "gail.parquet", "gail.json")]
    for _ in range(2):  # other weights each time
        write_network(weights, "gail", [nn.Linear(COUNT, 1)], "tanh", squashed=False)
        drive.main(learned, made / "scenarios/test", *out)
        runs.append(set(pq.read_table(out[1])["run"].to_pylist()))
    assert len(set.union(*runs)) == 2
    assert set(pq.read_table(out[1])["inputs"].to_pylist()) == {f"{made / 'scenarios/test'} {weights}"}
