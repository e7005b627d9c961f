"""What trainings learn from does not stay in memory: four times the scenes take no more of it."""

import pickle
import shutil
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from drivegen.core import plugins
from drivegen.core.settings import build, read_section
from drivegen.generators._smart import tokens
from drivegen.goals import list_files
from drivegen.goals.list_files import read_lists
from drivegen.store.scenarios import write_shard
from stages import goal_lists, train_generator, train_planner
from stages._door import read_params
from tests.goals.test_goals_candidates import SETTINGS
from tests.scenes import busy_crossing

ROOT = Path(__file__).parents[2]
FEW, MANY = 3, 12


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A train and a validation split of one shard each, and the same with more train shards."""
    root = tmp_path_factory.mktemp("splits")
    scenes = [replace(busy_crossing(101), scenario_id=f"crossing-{n}") for n in range(4)]
    for shards in (FEW, MANY):
        source = root / str(shards) / "val" / "shard-00000.parquet"
        write_shard(source, scenes)
        (root / str(shards) / "train").mkdir()
        for number in range(shards):
            shutil.copy(source, root / str(shards) / "train" / f"shard-{number:05d}.parquet")
    return root


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def growth(work: Callable[[int], object]) -> int:
    """By how many bytes the highest memory of work(MANY) exceeds that of work(FEW)."""
    peaks = []
    work(FEW)  # compiles, imports and fills caches
    for shards in (FEW, MANY):
        tracemalloc.start()
        work(shards)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    return peaks[1] - peaks[0]


@pytest.mark.parametrize("name", ["bits", "trafficgen", "smart", "lctgen", "scene_transformer"])
def test_of_what_a_rival_learns_from_less_than_one_shard_stays(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tokens, "_POOL", 100)  # of motions that are looked at for a vocabulary
    plugin = plugins.load("generators", name)
    settings = build(plugin.Settings, read_section(f"train_generator.generators.{name}", ROOT / "params.yaml"), name)

    def objective(shards: int) -> None:
        train, validation = train_generator._examples(plugin, settings, folder / str(shards), 1)
        assert len(train) == 2 * 4 * shards  # every log and its twin
        plugin.objective(settings, plugin.network(settings), train, validation, 7)

    part = train_generator._shard_examples((plugin, settings, folder / str(FEW) / "val" / "shard-00000.parquet"))
    assert growth(objective) < len(pickle.dumps(part))


def test_of_what_a_planner_learns_from_less_than_one_shard_stays(folder: Path, tmp_path: Path) -> None:
    params = read_params("train_planner", train_planner.Params, ROOT / "params.yaml")
    plugin, params = plugins.load("planners", "route_fm"), replace(params, workers=1)
    values = params.planners["route_fm"]
    small = {"width": 16, "blocks": 1, "along": 4, "across": 4, "training": values["training"] | {"steps": 2, "report_every": 2}}
    settings = build(plugin.Settings, values | small, "route_fm")

    def trained(shards: int) -> None:
        train, validation = train_planner._examples(folder / str(shards), params)
        plugin(settings).fit(train, validation, 7, tmp_path, lambda _: None)

    shard = folder / str(FEW) / "val" / "shard-00000.parquet"
    part = train_planner._shard_examples((shard, params.seen, params.training_seed))
    assert growth(trained) < len(pickle.dumps((part.requests, part.motion)))


def test_of_lists_less_than_one_shard_stays(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(list_files, "GROUP", 40)
    params = goal_lists.Params(1, SETTINGS, goal_lists.Teacher("", ""))
    part = goal_lists._shard_lists((folder / str(FEW) / "val" / "shard-00000.parquet", SETTINGS, ""))
    monkeypatch.setattr(goal_lists, "_shard_lists", lambda task: replace(part, x=part.x.copy()))  # as long as that takes

    def listed(shards: int) -> None:
        shutil.rmtree("lists", ignore_errors=True)
        goal_lists.main(params, folder / str(shards), Path("lists"))
        learnt, _ = read_lists(Path("lists/train.parquet"), tmp_path)
        assert len(learnt) == shards * len(part)

    assert growth(listed) < len(pickle.dumps(part))
