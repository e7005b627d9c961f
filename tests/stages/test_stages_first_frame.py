"""Nothing of the future reaches who makes futures: two logs that begin alike give equal bytes, from whatever plugin."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from drivegen.core import plugins
from drivegen.core.methods import BOUND, read_methods
from drivegen.generators.base import Settings
from drivegen.generators.shared.learned import Learned
from drivegen.store.scenarios import write_shard
from stages import _without_goals, goals, rollout
from stages._door import read_params
from tests.futures import other_future, with_riders
from tests.generators.rivals import trained
from tests.models import two_lanes
from tests.scenes import busy_crossing

SHARD = "shard-00000.parquet"
METHODS = read_methods()


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two test splits of equal first frames."""
    scenes = [with_riders(busy_crossing(101, "a")), with_riders(two_lanes(9.0, "b", 81))]
    both = [tmp_path_factory.mktemp("begun"), tmp_path_factory.mktemp("begun")]
    write_shard(both[0] / "test" / SHARD, scenes)
    write_shard(both[1] / "test" / SHARD, [other_future(scene) for scene in scenes])
    return both


@pytest.fixture(scope="module")
def weights(models: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The models of tests, with room for rivals'."""
    return Path(shutil.copytree(models, tmp_path_factory.mktemp("weights") / "models"))


def recorded(folder: Path, models: Path, selector: str) -> bytes:
    """What stage goals leaves for the shard."""
    settings = read_params("goals", goals.Params).candidates
    out = folder / "goals" / selector
    if not (out / SHARD).exists():
        goals._shard_goals(goals.Task(folder / "test" / SHARD, models / "selector", out, settings, None))
    return (out / SHARD).read_bytes()


def quick(generation: Settings) -> Settings:
    return replace(generation, rollout=replace(generation.rollout, attempts=2, rounds=2))


def generated(folder: Path, models: Path, method: str) -> bytes:
    """What stage rollout, or that of those who follow no goals, leaves for the shard."""
    shard, out = folder / "test" / SHARD, folder / "generated" / method
    if METHODS[method].goals is None:
        _without_goals._generate_shard(_without_goals.Params(7, 1, 2), models, out, shard)
    else:
        recorded(folder, models, METHODS[method].goals or "")
        params = read_params("rollout", rollout.Params)
        params = replace(params, samples=2, generation=quick(params.generation))
        rollout._generate_shard(rollout.Task(shard, models, folder / "goals", out, params, ()))
    return (out / SHARD).read_bytes()


@pytest.mark.parametrize("selector", plugins.names("selectors"))
def test_goals_are_chosen_by_the_first_frame(selector: str, folders: list[Path], weights: Path) -> None:
    one, other = (recorded(folder, weights, selector) for folder in folders)
    assert (one == other) != plugins.load("selectors", selector).reads_log


@pytest.mark.parametrize("method", METHODS)
def test_futures_are_made_and_judged_by_the_first_frame(method: str, folders: list[Path], weights: Path) -> None:
    plugin = plugins.load("generators", method)
    if isinstance(plugin, type) and issubclass(plugin, Learned):
        trained(plugin.name)[0].save(weights / "generators" / plugin.name)
    one, other = (generated(folder, weights, method) for folder in folders)
    assert (one == other) != (METHODS[method].kind == BOUND)
