"""Tuning on toy scenes: every row begins with the same base, rows end elsewhere, and their test writes what the tables need."""

import copy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import orjson
import pyarrow as pa
import pytest
import torch

from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.samples import Samples
from drivegen.drivers import gail
from drivegen.drivers.shared.tuning import Continued, How, stand_at
from drivegen.report.published.amounts import amount_tables
from drivegen.report.published.drivers import primary, scenes
from drivegen.report.published.tuned import METRICS, PRIMARY, driver_rows, read_tests
from drivegen.store.lookup import logs_below
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import read_shard, write_shard
from stages import _lessons, drive_tuned, publish_drivers, tune, tune_amounts, tune_traffic
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS, straight_lessons, teaching
from tests.models import two_lanes, write_random_goals
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


def settings() -> tune.Params:
    """Two policy seeds, of which the second tunes on one method alone."""
    taught = {**read_section("train_driver.drivers.gail", PARAMS), **SHORT}
    params = read_params("tune", tune.Params, PARAMS)
    return replace(
        params,
        seeds=(7, 8),
        further=tune.Further(1, ("bits",)),
        methods=("bits", "drivegen", "log"),
        amounts=(1, 3),
        corner_cases=replace(params.corner_cases, adversaries={"random": {}}, queries=2, samples=1),
        drivers={"gail": {"base": taught, "tuned": taught}},
    )


def sources(root: Path) -> list[Path]:
    """Tuning scenes, more futures, models, goals, and the traffic that is attacked."""
    return [root / "scenes", root / "generated/drivegen", root / "models", root / "goals", root / "generated/drivegen"]


@pytest.fixture(scope="module")
def tuned(tmp_path_factory, models: Path) -> Path:
    root = tmp_path_factory.mktemp("tuned")
    for split in ("train", "val", "test"):
        scenes = [busy_crossing(31, f"{split}{n}-00000-1") for n in range(4)]
        write_shard(root / "scenarios" / split / "shard-00000.parquet", scenes)
    (root / "nothing").mkdir()
    for method in ("bits", "drivegen", "log"):
        futures = [noisy_samples(scene, 4, n) for n, scene in enumerate(scenes)]
        write_samples(root / "generated" / method / "shard-00000.parquet", futures)
        params = replace(read_params("tune_traffic", tune_traffic.Params, PARAMS), share=0.0)
        folders = root / "scenarios", root / "generated"
        tune_traffic.main(params, *folders, *[root / "nothing"] * 3, root / "models", root / "scenes" / method)
    (root / "models").symlink_to(models)
    write_random_goals(root / "goals/shard-00000.parquet", scenes)
    for seed in (7, 8):
        tune.main(settings(), root / "scenarios", *sources(root), root / f"data/gail/{seed}", root / f"tune-{seed}.json")
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


def test_every_row_has_weights_and_grades_and_seeds_after_so_many_have_only_those_that_are_named(tuned: Path):
    always = {"dataset", "dataset_longer", "bits"}
    for seed, rows in ((7, always | {"drivegen", "log", "amount_1", "amount_3", "corner_cases", "careful_teacher"}), (8, always)):
        assert {folder.name for folder in (tuned / f"data/gail/{seed}").iterdir()} == rows
        assert set(orjson.loads((tuned / f"tune-{seed}.json").read_bytes())) == rows


def test_shards_without_logs_are_passed_over_and_nothing_but_them_is_one_sentence(tuned: Path, tmp_path: Path):
    tests = replace(read_params("drive_tuned", drive_tuned.Params, PARAMS), workers=1, draws=20)
    none = [replace(busy_crossing(31, "test9-00000-1"), log=None)]
    for folder in ("some", "none"):
        write_shard(tmp_path / folder / "shard-00001.parquet", none)
    write_shard(tmp_path / "some/shard-00000.parquet", read_shard(tuned / "scenarios/test/shard-00000.parquet"))
    results = tmp_path / "results.parquet"
    drive_tuned.main(tests, tmp_path / "some", tuned / "data", results, tmp_path / "diversity.json")
    before = (tuned / "runs/here" / publish_drivers.TUNED).with_suffix(".json")
    assert (tmp_path / "diversity.json").read_bytes() == before.read_bytes()
    with pytest.raises(UnusableInput, match="holds no scenario with a log to drive through"):
        drive_tuned.main(tests, tmp_path / "none", tuned / "data", results, tmp_path / "diversity.json")


def test_no_row_of_cases_where_their_share_is_none():
    none = replace(settings(), amounts=(), corner_cases=replace(settings().corner_cases, share=0.0))
    assert none.rows(7) == _lessons.Rows(("bits", "drivegen", "log"), (), None)


def test_amounts_are_the_logs_and_the_first_futures_of_each(tuned: Path):
    of = _lessons.Sources(tuned / "scenarios/test", *sources(tuned))
    rows = dict(of.of(_lessons.Rows(("log",), (1, 3), None), None, 7))
    assert [len(rows[name]) for name in ("log", "amount_1", "amount_3")] == [4, 8, 16]
    for row in ("amount_1", "amount_3"):
        same = zip(rows["log"], rows[row], strict=False)
        assert all(np.array_equal(log.position, first.position) for (_, log), (_, first) in same)
    futures = read_samples(tuned / "generated/drivegen/shard-00000.parquet")
    added = [(scenario.scenario_id, motion.position) for scenario, motion in rows["amount_3"][4:]]
    wanted = [(samples.scenario_id, samples.motion[k].position) for samples in futures for k in range(3)]
    assert all(mine[0] == theirs[0] and np.array_equal(mine[1], theirs[1]) for mine, theirs in zip(added, wanted, strict=True))
    with pytest.raises(UnusableInput, match="holds 4 futures of a scenario, 5 are wanted"):
        dict(of.of(_lessons.Rows((), (5,), None), None, 7))


def test_a_quarter_of_the_lessons_are_cases_and_the_rest_are_drivegens(tuned: Path, monkeypatch):
    """Every lesson learnt in a straight lane stands for a case here; the attacked driver is the one that is handed over."""
    cases = straight_lessons(2).traffic
    attacked = []

    def attack(driver, ground, who, bounds, seed, law):
        attacked.append((driver.name, [choice.scenario.scenario_id for choice in ground.generated.choices], bounds.budget, seed))
        return {}

    monkeypatch.setattr(_lessons, "attacked", attack)
    monkeypatch.setattr(_lessons, "found_cases", lambda _: cases)
    of = _lessons.Sources(tuned / "scenarios/test", *sources(tuned))
    rows = _lessons.Rows((), (), settings().corner_cases)
    (name, lessons), (shown, others) = of.of(rows, SimpleNamespace(name="gail"), 8)
    assert (name, shown) == ("corner_cases", "careful_teacher")
    assert attacked == [("gail", [f"test{n}-00000-1" for n in range(4)], 2, 8)]
    ours = logs_below(tuned / "scenes/drivegen")
    assert [scene.scenario_id for scene, _ in lessons[:4]] == [scene.scenario_id for scene, _ in ours]
    assert len(lessons) == 5  # one of five: a third of four is nearest to one
    assert lessons[4][0] is cases[0][0]  # as the teacher drives in it
    assert len(others) == 5
    again, (scene, motion) = ours[[s.scenario_id for s, _ in ours].index(others[4][0].scenario_id)], others[4]
    assert scene.scenario_id == again[0].scenario_id  # one of the same scenes, without an attack,
    assert np.array_equal(motion.position[1:], again[1].position[1:])
    assert not np.array_equal(motion.position[0], again[1].position[0])  # as the teacher drives in it


def test_more_futures_are_made_from_the_first_frame_alone(models: Path, tmp_path: Path):
    scene = two_lanes(steps=41)
    params = replace(read_params("tune_amounts", tune_amounts.Params, PARAMS), samples=3, workers=1)
    made = []
    for name, one in (("whole", scene), ("first", first_frame(scene))):
        write_shard(tmp_path / name / "shard-00000.parquet", [one])
        tune_amounts.main(params, tmp_path / name, models, tmp_path / "out" / name)
        made.append((tmp_path / "out" / name / "shard-00000.parquet").read_bytes())
    assert made[0] == made[1]
    (samples,) = read_samples(tmp_path / "out/whole/shard-00000.parquet")
    assert len(samples.dropped) == 3
    assert samples.method == "drivegen"


def test_the_published_rows_are_those_that_are_asked_for(tuned: Path):
    rows = orjson.loads((tuned / "published/drivers.json").read_bytes())
    keys = {"data", "protocol", "driver", "method", "neighbours", "metric", "value", "low", "high", "n", "seeds"}
    assert all(set(row) == keys for row in rows)
    wanted = {"cr", "dis", "comfort", "div", "counted", "progress", "red_lights", "off_road", "imposed_braking"}
    assert wanted <= {row["metric"] for row in rows}
    of_seeds = {(row["method"], row["metric"]): row["seeds"] for row in rows}
    assert of_seeds["bits", "dis"] == of_seeds["dataset_longer", "dis"] == 1  # that every row has
    assert of_seeds["bits", "dis.minus_dataset_longer"] == 2
    table = (tuned / "published/drivers-here-clean-gail-replayed.md").read_text()
    assert "GAIL tuned on each method's scenes, neighbours replayed: These scenes" in table
    assert "| BITS |" in table
    assert "| BITS (paper, on Argoverse 2) | 0.15 | 56.90 | 5.10 | 7.84 |" in table
    seeds = {row.split("|")[1].strip(): row.split("|")[-2].strip() for row in table.splitlines() if row.startswith("| ")}
    assert seeds["BITS"] == seeds["DriveGen"] == "1"
    assert seeds["BITS (paper, on Argoverse 2)"] == ""
    assert "| DriveGen, a quarter corner cases |" in table
    amounts = (tuned / "published/drivers-here-clean-amounts.md").read_text()
    assert [line.split("|")[1].strip() for line in amounts.splitlines() if line.startswith("| ")][2:] == ["0", "1", "3"]
    assert "![" in amounts
    assert b"<svg" in (tuned / "published/drivers-here-clean-amounts.svg").read_bytes()
    assert "paper, on" not in (tuned / "published/drivers-here-clean-gail-reactive.md").read_text()


def counted(*runs: tuple[str, int, str]) -> pa.Table:
    """Of scenes a, b and c the first two are rich; each run is a method, a policy seed and the scenes in which it collides."""
    rows = [
        {"driver": "gail", "method": method, "metric": metric, "scenario": scenario, "seed": seed, "value": value}
        for method, seed, hits in runs
        for scenario in "abc"
        for metric, value in (
            ("counted", float(scenario in hits)),
            ("reactive.counted", 0.0),
            ("rich", float(scenario != "c")),
        )
    ]
    return pa.Table.from_pylist(rows)


def figures(results: pa.Table, monkeypatch, diversity: dict[int, dict] | None = None) -> dict[tuple[str, str], dict]:
    """Replayed neighbours' rows of the primary endpoint and of diversity by method and metric; `diversity` by policy seed."""
    monkeypatch.setattr("drivegen.report.published.tuned.METRICS", {PRIMARY: METRICS[PRIMARY]})
    methods = set(results["method"].to_pylist())
    of_seeds = (diversity or {7: {"value": None, "low": None, "high": None}}).items()
    kinds = ("replayed", "reactive")
    spread = {f"gail/{method}/{seed}/{kind}": one for method in methods for seed, one in of_seeds for kind in kinds}
    rows = driver_rows(read_tests("here", "clean", results, spread), 20, 7)
    return {(row["method"], row["metric"]): row for row in rows if row["neighbours"] == "replayed"}


def test_the_primary_endpoint_also_stands_by_policy_seed(monkeypatch):
    found = figures(counted(("bits", 7, "c"), ("bits", 8, "a")), monkeypatch)
    assert found["bits", "counted_rich.seed_7"]["value"] == 0.0
    assert found["bits", "counted_rich.seed_8"]["value"] == 0.5
    assert found["bits", "counted_rich"]["value"] == 0.25


def test_policy_seeds_are_named_in_order_since_rows_differ_in_which_they_have(monkeypatch):
    found = figures(counted(("bits", 10, "c"), ("bits", 7, "a"), ("bits", 8, "ab")), monkeypatch)
    assert [metric for _, metric in found if ".seed_" in metric] == [f"counted_rich.seed_{seed}" for seed in (7, 8, 10)]
    assert primary(found, "bits").note.endswith("; seeds 7: 0.500, 8: 1.000, 10: 0.000")


def test_a_figure_says_of_how_many_scenes_it_is(monkeypatch):
    found = figures(counted(("bits", 7, "c"), ("bits", 8, "a")), monkeypatch)
    assert (found["bits", "counted_rich"]["n"], found["bits", "counted_rich.seed_7"]["n"]) == (2, 2)
    assert scenes({**found, ("bits", "cr"): {"n": 3}}, "bits") == "3 scenes, 2 of them rich,"


def test_rows_with_unequal_seeds_are_compared_by_those_that_both_have(monkeypatch):
    """The reference has three seeds, the last two with two collisions; the other method has the first two of them."""
    results = counted(
        ("dataset_longer", 7, ""), ("dataset_longer", 8, "ab"), ("dataset_longer", 9, "ab"), ("bits", 7, "a"), ("bits", 8, "a")
    )
    found = figures(results, monkeypatch)
    for row in ("dataset_longer", "bits"):  # side by side they are of the same seeds
        assert (found[row, "counted_rich"]["seeds"], found[row, "counted_rich"]["value"]) == (2, 0.5)
    assert found["dataset_longer", "counted_rich.seed_9"]["value"] == 1.0
    apart = found["bits", "counted_rich.minus_dataset_longer"]
    assert (apart["seeds"], apart["value"]) == (2, pytest.approx(0.5 - 0.5))


def test_intervals_are_over_policy_seeds_too_and_paired_by_them(monkeypatch):
    """All recordings say the same, one seed of two says something else, of both rows alike."""
    results = counted(*((row, seed, hits) for row in ("dataset_longer", "bits") for seed, hits in ((7, ""), (8, "ab"))))
    found = figures(results, monkeypatch)
    of_row, apart = found["bits", "counted_rich"], found["bits", "counted_rich.minus_dataset_longer"]
    assert (of_row["low"], of_row["value"], of_row["high"]) == (0.0, 0.5, 1.0)
    assert (apart["low"], apart["value"], apart["high"]) == (0.0, 0.0, 0.0)


def test_diversity_reaches_over_the_intervals_of_all_policy_seeds(monkeypatch):
    diversity = {7: {"value": 1.0, "low": 0.9, "high": 1.1}, 8: {"value": 3.0, "low": 2.9, "high": 3.1}}
    found = figures(counted(("bits", 7, "a"), ("bits", 8, "a")), monkeypatch, diversity)["bits", "div"]
    assert [found[name] for name in ("low", "value", "high", "seeds")] == [0.9, 2.0, 3.1, 2]


def test_amounts_are_compared_with_the_logs_and_cases_with_the_same_scenes_without(monkeypatch):
    runs = [("log", 7, "ab"), ("amount_4", 7, "a"), ("amount_16", 7, ""), ("drivegen", 7, "a"), ("corner_cases", 7, "ab")]
    found = figures(counted(*runs, ("careful_teacher", 7, "")), monkeypatch)
    assert found["corner_cases", "counted_rich.minus_careful_teacher"]["value"] == 1.0
    assert found["careful_teacher", "counted_rich.minus_drivegen"]["value"] == -0.5
    assert found["amount_4", "counted_rich.minus_log"]["value"] == -0.5
    assert found["corner_cases", "counted_rich.minus_drivegen"]["value"] == 0.5
    assert ("drivegen", "counted_rich.minus_log") not in found
    assert ("amount_4", "counted_rich.minus_dataset_longer") not in found  # there is no such row here
    rows = [row | {"metric": metric} for row in found.values() for metric in {row["metric"], "cr"}]
    (table,) = amount_tables(rows, {"here": ("These scenes", 3)})
    assert [[cell.text for cell in row.cells[:3]] for row in table.rows] == [
        ["0", "1.000", ""],
        ["4", "0.500", "-0.500"],
        ["16", "0.000", "-1.000"],
    ]
