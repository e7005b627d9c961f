"""Stage beset: what attackers find in scenes on new maps, vehicles placed as always or so that they beset the target.

argv: maps (a folder with <name>/map.net.xml), assets, gaps, models, besetting scenes with their traffic (folder of shards),
results (JSON, a list of rows {driver, placed, method, metric, value, low, high, n}). Neighbours are replayed.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.adversaries.shared.findings import Findings
from drivegen.adversaries.shared.ground import sampled
from drivegen.core import plugins
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.intervals import bootstrap_means
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.core.seeds import rng
from drivegen.core.settings import Count, Index
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.placement.gaps import Gaps
from drivegen.placement.scenes import Initialiser
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import Table
from drivegen.rollout.batch import choose, roll_out
from drivegen.rollout.models import Equipment
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.store.scenarios import write_shard
from drivegen.sumo.network import Network
from drivegen.world.reactive import Reaction
from stages._door import enter, read_params, require, spread

SOURCE, SELECTOR = "DriveGen (map from words)", "learned"
PLACED = {"as always": False, "besetting": True}
METRICS = ("counted", "avoidable", "legal_share", "survives_reaction")
"""Shares of scenes; the last two of cases."""


@dataclass(frozen=True)
class Params:
    """Section `beset`.

    Attributes:
        per_map: scenes on each map, placed in each way. generation: of their traffic.
        allowed, queries, reaction_steps, reaction: as in the stage `attack`. draws: bootstrap draws behind intervals, over maps.
    """

    seed: int
    workers: Count
    per_map: Count
    generation: GeneratorSettings
    allowed: str
    queries: Count
    reaction_steps: Index
    reaction: Reaction
    drivers: dict[str, dict[str, Any]]
    adversaries: dict[str, dict[str, Any]]
    draws: Count


@dataclass(frozen=True)
class Task:
    """One map."""

    network: Path
    assets: Path
    gaps: Path
    models: Path
    params: Params


Key = tuple[str, str, str]
"""Driver, how vehicles were placed, adversary."""


def main(params: Params, maps: Path, assets: Path, gaps: Path, models: Path, scenes: Path, results: Path) -> None:
    """Place, generate and attack, map by map."""
    files = sorted(require(maps, "run the maps stage").glob("*/map.net.xml"))
    if not files:
        raise MissingTool(f"{maps} holds no map: run the maps stage")
    tasks = [Task(file, assets, gaps, models, params) for file in files]
    besetting, found, cities = list[Scenario](), dict[Key, list[Findings]](), dict[Key, list[str]]()
    for task, (scenarios, parts) in spread(_on_map, tasks, params.workers, "beset"):
        besetting += scenarios
        for key, part in parts.items():
            found.setdefault(key, []).append(part)
            cities.setdefault(key, []).extend([task.network.parent.name] * len(part.scenarios))
    write_shard(scenes / "shard-00000.parquet", besetting)
    write_json(results, [row for key, parts in found.items() for row in _rows(key, Findings.joined(parts), cities[key], params)])


def _on_map(task: Task) -> tuple[list[Scenario], dict[Key, Findings]]:
    """The besetting scenes of a map with their traffic, and what was found in both kinds of scenes."""
    params = task.params
    tools = Equipment.open(task.models, params.generation.planner, SELECTOR)
    drivers = [plugins.make("drivers", name, params.drivers, "beset.drivers") for name in params.drivers]
    bounds, besetting, found = Bounds(params.allowed, params.queries, params.reaction_steps), list[Scenario](), {}
    for placed, beset in PLACED.items():
        ground = _ground(_placed(task, beset), tools, params)
        if not len(ground.of):
            continue
        if beset:
            besetting = [_with_traffic(*one) for one in zip(ground.scenarios, ground.traffic, strict=True)]
        arena = Arena(drivers[0], ground, bounds, params.seed)
        for driver in drivers:
            for name in params.adversaries:
                own = arena.again(driver)
                plugins.make("adversaries", name, params.adversaries, "beset.adversaries").attack(own)
                found[driver.name, placed, name] = Findings.of(own.runs(), driver, name, params.reaction)
    return besetting, found


def _placed(task: Task, beset: bool) -> Iterator[Scenario]:
    """The scenes on a map, without those in which the target found no place."""
    network = Network.read(task.network.read_bytes(), str(task.network))
    table = Table.from_arrow(read_assets(require(task.assets, "run the assets stage")), str(task.assets))
    gaps = Gaps.from_arrow(read_assets(require(task.gaps, "run the assets stage")), str(task.gaps))
    settings = read_params("place.initial", InitialSettings)
    initialiser = Initialiser(network, task.network.parent.name, SOURCE, table, settings, gaps)
    for number in range(task.params.per_map):
        try:
            yield initialiser.scenario(number, task.params.seed, beset)[0]
        except UnusableInput as error:
            if error.reason != "no-place":
                raise


def _ground(scenarios: Iterator[Scenario], tools: Equipment, params: Params) -> Ground:
    """One scene of traffic for each, those apart in which nothing legal was found for the target."""
    generation = params.generation
    choices = choose(list(scenarios), tools.selector, generation.candidates, generation.temperature)
    futures = roll_out(choices, tools.planner, tools.limits, generation.rollout, 1, params.seed, "drivegen") if choices else []
    kept = [n for n, future in enumerate(futures) if not future.dropped[0, TARGET]]
    return sampled([choices[n] for n in kept], [futures[n] for n in kept], 1, tools.planner, tools.limits)


def _with_traffic(scenario: Scenario, traffic: Trajectories) -> Scenario:
    there = np.flatnonzero(traffic.valid[:, 0])
    return replace(scenario, vehicles=scenario.vehicles[there], log=traffic[there])


def _rows(key: Key, found: Findings, cities: list[str], params: Params) -> Iterator[dict[str, Any]]:
    """Means with 95 % over maps."""
    driver, placed, method = key
    columns = np.column_stack([found.metrics[name] for name in METRICS])
    about = {"driver": driver, "placed": placed, "method": method}
    intervals = bootstrap_means(columns, cities, params.draws, rng(params.seed, "beset", "bootstrap"))
    for metric, interval in zip(METRICS, intervals, strict=True):
        yield {**about, "metric": metric, **asdict(interval), "n": len(columns)}
    yield {**about, "metric": "kinds", "value": len(set(found.kinds)), "low": None, "high": None, "n": len(columns)}


if __name__ == "__main__":
    enter("beset", Params, main)
