"""Stage tune_traffic@<method>: the scenes that drivers are tuned on, one future of each by a method, some replaced by new ones.

argv: scenarios (folder of splits), samples of the test split's first frames (folder of methods), shipped scenarios, assets,
gaps, models, tuning scenes (folder of shards; its name is the method's).
Methods that make scenes of their own get `share` of them anew: DriveGen has new roads with new vehicles, DriveGen without maps,
TrafficGen and LCTGen have new vehicles on roads of the split.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from drivegen.core import plugins, seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Actors, Scenario, Vehicles
from drivegen.core.settings import Count, Share
from drivegen.generators.base import Settings
from drivegen.metrics.displacement import scene_errors
from drivegen.placement.draws import Draws
from drivegen.placement.gaps import Gaps
from drivegen.placement.on_logs import OURS, OnLogs
from drivegen.placement.scenes import Settings as PlaceSettings
from drivegen.placement.table import Table
from drivegen.store.assets import read_assets
from drivegen.store.lookup import futures_in
from drivegen.store.scenarios import read_shard, shards, write_shard
from stages._code_library import library
from stages._door import read_params, require

LIKE = {"drivegen_without_maps": "drivegen"}
"""Whose samples a method takes that differs in the new scenes alone."""

NEW_ROADS = "drivegen"

Place = Callable[[Scenario], Vehicles]


@dataclass(frozen=True)
class Params:
    """`share` of the scenes are new; `best_of`: of so many futures the one nearest to the log is taken (1: any, unseen)."""

    seed: int
    share: Share
    best_of: Count
    generation: Settings


def main(
    params: Params, scenarios: Path, generated: Path, shipped: Path, assets: Path, gaps: Path, models: Path, out: Path
) -> None:
    """As many scenes as the split has."""
    method = out.name
    sampled = list(_sampled(params, scenarios / "test", generated / LIKE.get(method, method)))
    count = round(params.share * len(sampled))
    new = list(_new(method, params, scenarios, sampled, count, shipped, assets, gaps, models))
    order = seeds.rng(params.seed, "tune_traffic", method).permutation(len(sampled))[: len(sampled) - len(new)]
    scenes = [sampled[i] for i in sorted(order)] + new
    write_shard(out / "shard-00000.parquet", scenes)
    print(f"tune_traffic {method}: {len(scenes)} scenes, {len(new)} of them new", flush=True)


def _sampled(params: Params, split: Path, generated: Path) -> Iterator[Scenario]:
    """Every scenario with a future of the method's in the place of its log."""
    for file in shards(require(split, "run the ingest stage")):
        for scenario, samples in futures_in(require(generated / file.name, "run the rollout stages"), split):
            if scenario.log is None:
                continue
            motion = samples.motion[: params.best_of]
            best = int(np.argmin(scene_errors(motion, scenario.log)[0])) if params.best_of > 1 else 0
            yield replace(scenario, log=motion[best])


def _new(
    method: str, params: Params, scenarios: Path, given: list[Scenario], count: int, shipped: Path, assets: Path, gaps: Path,
    models: Path,
) -> Iterator[Scenario]:  # fmt: skip
    """Scenes that a method makes from nothing, or from a road; none where it can't."""
    if method == NEW_ROADS:
        stock = [scene for file in shards(require(shipped, "run the ship stage")) for scene in read_shard(file)]
        chosen = seeds.rng(params.seed, "tune_traffic", "shipped").permutation(len(stock))[:count]
        yield from (stock[i] for i in sorted(chosen))
        return
    plugin = plugins.load("generators", LIKE.get(method, method))
    if method not in LIKE and not plugin.about.places:
        return
    generator = plugin(models, params.generation)
    if method in LIKE:
        place: Place = _ours(params, assets, gaps)
    else:
        place = next(iter(generator.placements(library(scenarios, params.seed), params.seed).values()))
    random = seeds.rng(params.seed, "tune_traffic", "roads").permutation(len(given))
    fresh = list(islice((one for i in random if (one := _peopled(given[i], place)) is not None), count))
    futures = generator.generate(fresh, 1, params.seed)
    yield from (replace(one, log=samples.motion[0]) for one, samples in zip(fresh, futures, strict=True))


def _ours(params: Params, assets: Path, gaps: Path) -> Place:
    table, draws = Table.from_arrow(read_assets(assets), str(assets)), Draws(Gaps.from_arrow(read_assets(gaps), str(gaps)))
    own = OnLogs(table, draws, read_params("place.initial", PlaceSettings), params.seed)
    name = next(name for name in own.names if name.startswith(OURS.format("data")))
    return lambda scenario: own.places(scenario)[name]


def _peopled(road: Scenario, place: Place) -> Scenario | None:
    """A scene on the road of another one, with other vehicles and nobody on foot; None where there is no room."""
    try:
        vehicles = place(road)
    except UnusableInput as error:
        if error.reason != "no-place":
            raise
        return None
    return replace(road, scenario_id=f"{road.scenario_id}-new", vehicles=vehicles, log=None, context=Actors.none(road.steps))
