"""Tuning on toy scenes: every row begins with the same base, rows end elsewhere, and their test writes what the tables need."""

import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pyarrow as pa
import pytest
import torch

from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.drivers import gail
from drivegen.drivers.shared.tuning import Continued, How, stand_at
from drivegen.report.published_drivers import read_tests
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, write_shard
from stages import drive_tuned, publish_drivers, tune, tune_traffic
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS, straight_lessons, teaching
from tests.scenes import busy_crossing, noisy_samples

PPO = {"rows": 16, "epochs": 1, "batch": 512, "learning_rate": 0.001, "clip": 0.2, "discount": 0.98, "smoothing": 0.95}
SHORT = {"course": {"rounds": 1, "grade_every": 1}, "clone_steps": 20, "ppo": PPO}


def test_a_tuned_driver_begins_where_its_base_stands_with_learning_rates_of_its_own():
    lessons = straight_lessons(2)
    base = gail.Plugin.pupil(teaching("gail", **SHORT), lessons, 7)
    base.begin(7)
    base.study(1, 7)
    slower = teaching("gail", **{**SHORT, "ppo": {**PPO, "learning_rate": 0.0001}})
    pupil = Continued(base, gail.Plugin.pupil(slower, lessons, 8))
    pupil.begin(8)
    for name, part in pupil.parts.items():
        mine, theirs = part.state_dict(), base.parts[name].state_dict()
        if "adam" not in name:
            assert all(torch.equal(mine[key], theirs[key]) for key in mine), name
    assert pupil.parts["adam"].param_groups[0]["lr"] == 0.0001
    assert pupil.parts["adam"].state_dict()["state"].keys() == base.parts["adam"].state_dict()["state"].keys()
    before = [value.clone() for value in base.policy.parameters()]
    pupil.study(1, 9)
    assert all(torch.equal(old, new) for old, new in zip(before, base.policy.parameters(), strict=True))
    assert not torch.equal(before[0], next(iter(pupil.policy.parameters())))


def test_what_is_tuned_and_its_average_both_begin_at_the_row_of_the_base():
    """Not at the network of the last round, of which a row's policy is an average, or an earlier one."""
    lessons = straight_lessons(2)
    base = gail.Plugin.pupil(teaching("gail", **SHORT), lessons, 7)
    base.begin(7)
    best = copy.deepcopy(base.policy)
    base.study(1, 7)
    stand_at(base, best)
    pupil = Continued(base, gail.Plugin.pupil(teaching("gail", **SHORT), lessons, 8))
    pupil.begin(8)
    for network in (pupil.policy, pupil.tries):
        assert all(torch.equal(a, b) for a, b in zip(network.layers.parameters(), best.layers.parameters(), strict=True))


def test_a_driver_without_settings_is_one_sentence():
    with pytest.raises(UnusableInput, match=r"tune.drivers has no settings `base` and `tuned` for 'gail'"):
        How.of("gail", {"sac": {"base": {}, "tuned": {}}}, "tune.drivers")


@pytest.fixture(scope="module")
def tuned(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("tuned")
    for split in ("train", "val", "test"):
        scenes = [busy_crossing(31, f"{split}{n}-00000-1") for n in range(4)]
        write_shard(root / "scenarios" / split / "shard-00000.parquet", scenes)
    write_samples(root / "generated/bits/shard-00000.parquet", [noisy_samples(scene, 4, n) for n, scene in enumerate(scenes)])
    params = replace(read_params("tune_traffic", tune_traffic.Params, PARAMS), share=0.0)
    nothing = root / "nothing"
    tune_traffic.main(params, root / "scenarios", root / "generated", *[nothing] * 3, root / "models", root / "scenes/bits")
    taught = {**read_section("train_driver.drivers.gail", PARAMS), **SHORT}
    settings = tune.Params((7,), ("bits",), {"gail": {"base": taught, "tuned": taught}})
    tune.main(settings, root / "scenarios", root / "scenes", root / "data/gail/7", root / "tune.json")
    tests = replace(read_params("drive_tuned", drive_tuned.Params, PARAMS), workers=1, draws=20)
    results = root / "runs/here" / publish_drivers.TUNED
    drive_tuned.main(tests, root / "scenarios/test", root / "data", results, results.with_suffix(".json"))
    published = publish_drivers.Params(7, 50, {}, {"here": {"protocol": "clean", "title": "These scenes"}})
    publish_drivers.main(published, root / "runs", root / "published")
    return root


def test_scenes_are_any_future_of_the_method_or_the_best_of_several(tuned: Path):
    (shard,) = (tuned / "scenes/bits").glob("*.parquet")
    scenes = {scene.scenario_id: scene for scene in read_shard(shard)}
    base = busy_crossing(31, "test0-00000-1")
    samples: Samples = noisy_samples(base, 4, 0)
    assert np.allclose(scenes["test0-00000-1"].log.position, samples.motion[0].position, atol=0.01)


def test_every_row_has_weights_and_grades(tuned: Path):
    rows = {"dataset", "dataset_longer", "bits"}
    assert {folder.name for folder in (tuned / "data/gail/7").iterdir()} == rows
    assert set(orjson.loads((tuned / "tune.json").read_bytes())) == rows


def test_the_published_rows_are_those_that_are_asked_for(tuned: Path):
    rows = orjson.loads((tuned / "published/drivers.json").read_bytes())
    keys = {"data", "protocol", "driver", "method", "neighbours", "metric", "value", "low", "high", "n", "seeds"}
    assert all(set(row) == keys for row in rows)
    wanted = {"cr", "dis", "comfort", "div", "counted", "progress", "red_lights", "off_road", "imposed_braking"}
    assert wanted <= {row["metric"] for row in rows}
    value = {(row["method"], row["neighbours"], row["metric"]): row["value"] for row in rows}
    longer, bits = value["dataset_longer", "replayed", "dis"], value["bits", "replayed", "dis"]
    assert value["bits", "replayed", "dis.minus_dataset_longer"] == pytest.approx(bits - longer)
    table = (tuned / "published/drivers-here-clean-gail-replayed.md").read_text()
    assert "GAIL tuned on each method's scenes, neighbours replayed: These scenes" in table
    assert "| BITS |" in table
    assert "| BITS (paper, on Argoverse 2) | 0.15 | 56.90 | 5.10 | 7.84 |" in table
    assert "policy seeds: 1" in table
    assert "paper, on" not in (tuned / "published/drivers-here-clean-gail-reactive.md").read_text()


def test_the_primary_endpoint_also_stands_by_policy_seed():
    """Of scenes a, b and c the first two are rich; the second seed collides in a, the first in c alone."""
    rows = [
        {"driver": "gail", "method": "bits", "metric": metric, "scenario": scenario, "seed": seed, "value": value}
        for seed, hit in ((7, "c"), (8, "a"))
        for scenario in "abc"
        for metric, value in (
            ("counted", float(scenario == hit)),
            ("reactive.counted", 0.0),
            ("rich", float(scenario != "c")),
        )
    ]
    tests = read_tests("here", "clean", pa.Table.from_pylist(rows), {})
    assert tests.primary == {("gail", "bits"): {7: 0.0, 8: 0.5}}
