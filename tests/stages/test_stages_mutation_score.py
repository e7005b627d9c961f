"""The stage `mutation_score` on hand-made scenes, and what the door `publish_corner` makes of it."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pyarrow.parquet as pq
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.drivers.mutants.table import MUTATIONS
from drivegen.metrics.mutation_score import Settings
from drivegen.store.files import write_json
from drivegen.store.lookup import evenly, in_turn, shared
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from stages import mutation_score, publish_corner
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS
from tests.models import write_random_goals
from tests.scenes import busy_crossing, drive, noisy_samples, scenario, stack, straight_road

LINE = straight_road().centreline[0].astype(np.float64)
MINE = [name for name in MUTATIONS if name.startswith("idm.")]
SHARD = "shard-00000.parquet"


def parked(number: int) -> Scenario:
    """A recording of somebody who stands in the way."""
    return scenario(straight_road(), stack([drive(LINE, 10, 10, 101), drive(LINE, 80, 0, 101)]), f"parked{number}-0")


def write(root: Path, models: Path, *shards: list[Scenario]) -> Path:
    """Below `root`: scenes, samples that are the logs, goals, and a link to the models."""
    for number, scenes in enumerate(shards):
        shard = f"shard-{number:05}.parquet"
        write_shard(root / "test" / shard, scenes)
        samples = [noisy_samples(scene, 2) for scene in scenes]
        for folder in ("generated/drivegen", "round"):
            write_samples(root / folder / shard, samples)
        write_random_goals(root / "goals" / shard, scenes)
    (root / "models").symlink_to(models)
    return root


@pytest.fixture(scope="module")
def made(tmp_path_factory, models: Path) -> Path:
    """Twelve recordings of somebody who stands in the way, one of a crossing."""
    scenes = [*map(parked, range(12)), busy_crossing(101, "crossing-0")]
    return write(tmp_path_factory.mktemp("mutation"), models, scenes)


def params(**changes: object) -> mutation_score.Params:
    values = read_params("mutation_score", mutation_score.Params, PARAMS)
    drivers = {"idm": read_section("mutation_score.drivers.idm", PARAMS)}
    small = {"workers": 1, "methods": ("drivegen",), "adversaries": {"random": {}}, "drivers": drivers, "runs": 26, "queries": 2}
    return replace(values, **{**small, "test": Settings(0.05, (5, 10), 4), **changes})


def run(made: Path, out: Path, **changes: object) -> dict[str, float]:
    places = (made / "test", made / "generated", made / "models", made / "goals", made / "round")
    return mutation_score.main(params(**changes), *places, out / "score.parquet", out / publish_corner.SCORE)


@pytest.fixture(scope="module")
def once(made, tmp_path_factory) -> tuple[Path, dict[str, float]]:
    """A folder with what a run in one process writes, and what it returns."""
    folder = tmp_path_factory.mktemp("once")
    return folder, run(made, folder)


def test_every_tester_tests_every_driver_and_who_ignores_the_standing_is_killed(once):
    folder, took = once
    score = orjson.loads((folder / publish_corner.SCORE).read_bytes())
    assert list(score) == ["drivegen", "log", "random"]
    assert all(set(each["drivers"]) == set(MINE) for each in score.values())
    assert [score[tester]["drivers"][MINE[0]]["runs"] for tester in ("log", "drivegen")] == [13, 26]
    assert score["random"]["runs"] <= 26
    standing = score["log"]["drivers"]["idm.ignores_standing"]
    assert (standing["killed"], standing["kinds"], standing["named"], standing["p"]) == (True, {"standing": 12}, True, 0.5**12)
    assert all(each["false_kills"] == 0 for each in score.values())
    rows = pq.read_table(folder / "score.parquet").to_pylist()
    runs = sum(row["value"] for row in rows if row["metric"] == "runs")
    assert runs == took["runs"] == sum(each["runs"] for tester in score.values() for each in tester["drivers"].values())
    mine = [row for row in rows if (row["method"], row["driver"]) == ("log", "idm.ignores_standing")]
    failed = {row["scenario"] for row in mine if row["metric"] == "only_mutant" and row["value"]}
    assert failed == {f"parked{n}-0" for n in range(12)}


def test_the_same_seed_gives_the_same_bytes_whatever_the_processes(models, tmp_path):
    """Of two shards, since each is a task: one alone would be done here."""
    made = write(tmp_path, models, [parked(0)], [busy_crossing(41, "crossing-0")])
    for workers in (1, 2):
        run(made, tmp_path / str(workers), workers=workers, methods=(), adversaries={}, runs=4)
    for file in ("score.parquet", publish_corner.SCORE):
        assert (tmp_path / "1" / file).read_bytes() == (tmp_path / "2" / file).read_bytes()


def test_who_has_too_few_runs_is_told(made, tmp_path):
    with pytest.raises(UnusableInput, match=r"random has nothing to drive in .*mutation_score\.runs is too small"):
        run(made, tmp_path, runs=1, methods=())


def test_traffic_comes_in_turns_and_few_runs_are_spread(made):
    found = in_turn(made / "test" / SHARD, made / "round" / SHARD, 15)
    assert [turn for *_, turn in found] == [0] * 13 + [1] * 2
    assert found[13][0].scenario_id == "parked0-0"
    spread = in_turn(made / "test" / SHARD, None, 3)
    assert [scene.scenario_id for scene, *_ in spread] == ["parked0-0", "parked4-0", "parked8-0"]
    assert (evenly(5, 9), evenly(0, 4), evenly(10, 3)) == ([0, 1, 2, 3, 4], [], [0, 3, 6])
    assert shared(10, [1, 1, 1]) == [3, 4, 3]
    assert shared(10, []) == []


def test_the_score_is_published_with_one_table_and_one_chart(once, tmp_path):
    for seed in ("7", "8"):
        place = tmp_path / "runs" / seed / publish_corner.SCORE
        place.parent.mkdir(parents=True)
        shutil.copy(once[0] / publish_corner.SCORE, place)
        write_json(tmp_path / "runs" / seed / "reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7, 8], {}, 20), tmp_path / "runs", tmp_path / "out")
    rows = orjson.loads((tmp_path / "out/mutation_score.json").read_bytes())
    found = {(row["tester"], row["driver"], row["metric"]): row for row in rows}
    score = orjson.loads((tmp_path / "runs/7" / publish_corner.SCORE).read_bytes())
    killed = {"metric": "killed", "value": score["log"]["killed"], "n": 8, "seeds": 2}
    assert found["log", "", "killed"] == {"data": "sumo_corpus", "tester": "log", "driver": "", **killed}
    assert found["log", "idm.ignores_standing", "p"]["value"] == 0.5**12
    assert found["log", "", "runs_to_kill"]["value"] is None  # most are not killed
    text = (tmp_path / "out/mutation-score.md").read_text()
    assert "| logs | no | 13 (13 recordings) |" in text
    assert "| random goals | yes |" in text
    assert "![Mutation score" in text
    assert b"<!-- logs -->" in (tmp_path / "out/mutation-score.svg").read_bytes()


def test_without_a_score_nothing_of_it_is_published(tmp_path):
    write_json(tmp_path / "runs/7/reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    assert not (tmp_path / "out/mutation_score.json").exists()
    assert "Runs: 7; of code None." in (tmp_path / "out/corner.md").read_text()
