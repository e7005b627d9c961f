"""The stage `repair` on hand-made scenes: who saw which cases, what is compared with what, and what the door publishes of it."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import orjson
import pytest

from drivegen.adversaries.shared.findings import Findings
from drivegen.adversaries.shared.repair import attacked, halved, lessons_of
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import recording
from drivegen.core.scenario import TARGET
from drivegen.drivers import idm
from drivegen.drivers.shared.tuning import exemplary, mixed
from drivegen.rollout.choices import choose
from drivegen.selectors.random import Plugin as Random
from drivegen.store.files import write_json
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, write_shard
from stages import publish_corner, repair
from stages._door import read_params, read_section
from tests.checking import IDM
from tests.drivers.taught import PARAMS, straight_lessons
from tests.models import candidate_settings, write_random_goals
from tests.scenes import busy_crossing, drive, noisy_samples, scenario, stack, straight_road

LINE = straight_road().centreline[0].astype(np.float64)
SHARD = "shard-00000.parquet"
PPO = {"rows": 16, "epochs": 1, "batch": 512, "learning_rate": 0.001, "clip": 0.2, "discount": 0.98, "smoothing": 0.95}
SHORT = {"course": {"rounds": 1, "grade_every": 1}, "clone_steps": 50, "ppo": PPO}


def standing(name: str):
    """Somebody drives towards somebody who stands, and goes on through him, as logs do not."""
    return scenario(straight_road(), stack([drive(LINE, 10, 10, 41), drive(LINE, 40, 0, 41)]), name)


@pytest.fixture(scope="module")
def made(tmp_path_factory, models: Path) -> Path:
    root = tmp_path_factory.mktemp("repair")
    lessons = [replace(scene, log=motion) for scene, motion in straight_lessons(6).traffic]
    for split in ("train", "val"):
        write_shard(root / "scenarios" / split / SHARD, lessons)
    scenes = [*(standing(f"parked{n}-0") for n in range(4)), busy_crossing(41, "crossing-0"), busy_crossing(41, "other-0")]
    write_shard(root / "scenarios/test" / SHARD, scenes)
    write_samples(root / "round" / SHARD, [noisy_samples(scene, 2) for scene in scenes])
    write_random_goals(root / "goals" / SHARD, scenes)
    (root / "models").symlink_to(models)
    return root


def run(made: Path, out: Path) -> list[dict[str, object]]:
    params = read_params("repair", repair.Params, PARAMS)
    how = {**read_section("train_driver.drivers.gail", PARAMS), **SHORT}
    small = {"drivers": {"gail": {"base": how, "tuned": how}}, "adversaries": {"random": {}, "dataset": {}}, "queries": 2}
    places = (made / "scenarios", made / "models", made / "goals", made / "round")
    repair.main(replace(params, **small, draws=20), *places, out / "weights/gail", out / "gail.json")
    return orjson.loads((out / "gail.json").read_bytes())


@pytest.fixture(scope="module")
def once(made, tmp_path_factory) -> tuple[Path, list[dict[str, object]]]:
    folder = tmp_path_factory.mktemp("once")
    return folder, run(made, folder)


def test_each_version_is_tested_in_every_scene_and_the_difference_is_that_of_the_means(once):
    folder, rows = once
    value = {(row["version"], row["tester"], row["metric"]): row["value"] for row in rows}
    assert {key[0] for key in value} == {"before", "longer", "repaired"}
    assert all(row["n"] == 6 for row in rows)
    for tester in ("random", "dataset"):
        repaired, longer = (value[version, tester, "counted"] for version in ("repaired", "longer"))
        assert value["repaired", tester, "counted.minus_longer"] == pytest.approx(repaired - longer)
    kinds = sum(
        of
        for (version, tester, metric), of in value.items()
        if metric.startswith("kind.") and version == "before" and tester == "random"
    )
    assert kinds == pytest.approx(value["before", "random", "counted"])  # a counted scene has one kind
    assert {path.name for path in (folder / "weights/gail").iterdir()} == {"before", "longer", "repaired_0", "repaired_1"}


def test_nobody_is_tested_in_recordings_whose_cases_it_learnt_from(made, tmp_path, monkeypatch):
    """Every log stands for a case of its scenario here, so that there is one in each."""
    taught: list[set[str]] = []
    tested: list[tuple[str, set[str]]] = []

    def cases(found: dict[str, Findings]) -> list[SimpleNamespace]:
        names = {name for findings in found.values() for name in findings.scenarios}
        return [
            SimpleNamespace(scenario=s, traffic=s.log)
            for s in read_shard(made / "scenarios/test" / SHARD)
            if s.scenario_id in names
        ]

    def shown(some, teacher):
        return [(case.scenario, case.traffic) for case in some]

    def mix(logs, some, share):
        taught.append({recording(scene.scenario_id) for scene, _ in some})
        return mixed(logs, some, share)

    def attack(driver, half, *rest):
        tested.append((driver, {recording(scene.scenario_id) for scene in half.generated.scenarios}))
        return attacked(driver, half, *rest)

    for name, spy in (("found_cases", cases), ("mixed", mix), ("attacked", attack), ("lessons_of", shown)):
        monkeypatch.setattr(repair, name, spy)
    run(made, tmp_path)
    *_, first, second = tested
    assert first[0] is not second[0]
    assert [len(some) for some in taught] == [3, 3]
    assert not taught[0] & first[1]
    assert not taught[1] & second[1]


def test_the_same_seed_gives_the_same_bytes(made, once, tmp_path):
    run(made, tmp_path)
    assert (tmp_path / "gail.json").read_bytes() == (once[0] / "gail.json").read_bytes()


def test_scenarios_of_a_recording_are_in_one_half(made):
    scenes = [standing(f"parked{n // 2}-{n % 2}") for n in range(8)]
    choices, samples = choose(scenes, Random(), candidate_settings(), 1.0), [noisy_samples(scene, 2) for scene in scenes]
    both = halved(choices, samples, 2, None, None, 7)
    sides = [{recording(scene.scenario_id) for scene in half.generated.scenarios} for half in both]
    assert [len(side) for side in sides] == [2, 2]
    assert not sides[0] & sides[1]
    assert [len(half.generated.traffic) for half in both] == [8, 8]
    with pytest.raises(UnusableInput, match="all scenarios are of one recording"):
        halved(choices[:2], samples[:2], 2, None, None, 7)


def test_a_quarter_of_the_lessons_are_cases_and_these_show_how_not_to_collide():
    logs, cases = straight_lessons(6).traffic, [(standing("bad-0"), standing("bad-0").log)]
    assert exemplary(cases) == []  # its target drives through somebody
    assert exemplary([*cases, logs[0]]) == [logs[0]]
    assert exemplary([]) == []
    whole = mixed(logs, logs[:2], 0.25)
    assert len(whole) == 8
    assert whole[:6] == list(logs)
    assert whole[6:] == list(logs[:2])
    assert mixed(logs, [], 0.25) == list(logs)


def test_versions_are_published_side_by_side(once, tmp_path):
    met = ("before", "dataset", "kind.standing")
    for seed, share in (("7", 0.5), ("8", 0.0)):
        rows = [row | {"value": share} if (row["version"], row["tester"], row["metric"]) == met else row for row in once[1]]
        write_json(tmp_path / "runs" / seed / publish_corner.REPAIRED / "gail.json", rows)
        write_json(tmp_path / "runs" / seed / "reports/metrics/attack/gail.json", {})
    publish_corner.main(publish_corner.Params(7, [7, 8], {}, 20), tmp_path / "runs", tmp_path / "out")
    rows = orjson.loads((tmp_path / "out/repair.json").read_bytes())
    keys = {"data", "driver", "version", "tester", "metric", "value", "low", "high", "n", "seeds"}
    assert all(set(row) == keys and row["seeds"] == 2 for row in rows)
    text = (tmp_path / "out/repair-gail-dataset.md").read_text()
    assert "| tuned for as long, its cases among the logs |" in text
    assert "Scenes: 6, seeds: 2" in text
    assert "cases taught" in text
    assert text.splitlines()[2].endswith("| Dis [m] | Comfort | standing |")  # kinds that nobody met have no column
    assert "| taught on logs |" in text
    assert text.splitlines()[4].endswith("| 0.250 |")  # no recording differs from the others
    assert "repair-gail-random.md" in (tmp_path / "out/corner.md").read_text()


def test_a_case_is_shown_as_the_teacher_drives_in_it_if_it_gets_through():
    case, hopeless = (
        standing("bad-0"),
        scenario(straight_road(), stack([drive(LINE, 10, 20, 41), drive(LINE, 16, 0, 41)]), "bad-1"),
    )
    [(scene, motion)] = lessons_of([(s, s.log) for s in (case, hopeless)], idm.Plugin(IDM))
    assert scene is case
    assert motion.steps == case.log.steps
    assert motion.position[TARGET, -1, 0] < 36.0  # its own plan goes on through who stands at 40 m
    np.testing.assert_array_equal(motion.position[TARGET + 1 :], case.log.position[TARGET + 1 :])
    np.testing.assert_allclose(motion.position[TARGET, 0], case.log.position[TARGET, 0], atol=0.05)
    assert lessons_of([], idm.Plugin(IDM)) == []
