"""Stage beset: what attackers find in scenes on new maps, vehicles placed as always or so that they beset the target.

argv: maps (a folder with <name>/map.net.xml), assets, gaps, models, besetting scenes with their traffic (folder of shards),
results (JSON, a list of rows {driver, placed, method, metric, value, low, high, n}). Neighbours are replayed.
"""

from collections import defaultdict
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from drivegen.adversaries.shared.arena import Arena, Bounds
from drivegen.adversaries.shared.besetting import PLACED, Attack, besetting_rows
from drivegen.adversaries.shared.findings import Findings
from drivegen.adversaries.shared.ground import as_logs, generated
from drivegen.core import plugins
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count, Index
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.placement.gaps import Gaps
from drivegen.placement.scenes import Initialiser
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import Table
from drivegen.rollout.choices import choose
from drivegen.rollout.models import Equipment
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.store.scenarios import write_shard
from drivegen.sumo.network import Network
from drivegen.world.reactive import Reaction
from stages._door import read_params, require, spread

SOURCE, SELECTOR = "DriveGen (map from words)", "learned"


@dataclass(frozen=True)
class Params:
    """Section `beset`.

    Attributes:
        per_map: scenes on each map, placed in each way. generation: of their traffic. draws: behind intervals, over maps.
        allowed, queries, reaction_steps, reaction: as in the stage `attack`.
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

    def __post_init__(self) -> None:
        if not self.drivers:
            raise UnusableInput("stages/params.yaml: beset.drivers: name at least one")


@dataclass(frozen=True)
class Task:
    """One map."""

    network: Path
    assets: Path
    gaps: Path
    models: Path
    params: Params


def main(params: Params, maps: Path, assets: Path, gaps: Path, models: Path, scenes: Path, results: Path) -> None:
    """Place, generate and attack, map by map."""
    files = sorted(require(maps, "run the maps stage").glob("*/map.net.xml"))
    if not files:
        raise MissingTool(f"{maps} holds no map: run the maps stage")
    besetting, findings = list[Scenario](), defaultdict[Attack, list[tuple[str, Findings]]](list)
    tasks = [Task(file, assets, gaps, models, params) for file in files]
    for task, (scenarios, parts) in spread(_on_map, tasks, params.workers, "beset"):
        besetting += scenarios
        for attack, part in parts.items():
            findings[attack].append((task.network.parent.name, part))
    write_shard(scenes / "shard-00000.parquet", besetting)
    write_json(results, list(besetting_rows(findings, params.draws, params.seed)))


def _on_map(task: Task) -> tuple[list[Scenario], dict[Attack, Findings]]:
    """The besetting scenes of a map with their traffic, and what was found in both kinds of scenes."""
    params, generation = task.params, task.params.generation
    tools, initialiser = Equipment.open(task.models, generation.planner, SELECTOR), _initialiser(task)
    drivers = [plugins.make("drivers", name, params.drivers, "beset.drivers") for name in params.drivers]
    bounds, besetting, findings = Bounds(params.allowed, params.queries, params.reaction_steps), list[Scenario](), {}
    for placed, beset in PLACED.items():
        scenarios = list(initialiser.scenarios(params.per_map, params.seed, beset))
        choices = choose(scenarios, tools.selector, generation.candidates, generation.temperature)
        ground = generated(choices, tools.planner, tools.limits, generation.rollout, params.seed)
        if not len(ground.of):
            continue
        if beset:
            besetting = as_logs(ground)
        arena = Arena(drivers[0], ground, bounds, params.seed)
        for driver, name in product(drivers, params.adversaries):
            own = arena.again(driver)
            plugins.make("adversaries", name, params.adversaries, "beset.adversaries").attack(own)
            findings[Attack(driver.name, placed, name)] = Findings.of(own.runs(), driver, name, params.reaction)
    return besetting, findings


def _initialiser(task: Task) -> Initialiser:
    network, settings = Network.read(task.network.read_bytes(), str(task.network)), read_params("place.initial", InitialSettings)
    table = Table.from_arrow(read_assets(require(task.assets, "run the assets stage")), str(task.assets))
    gaps = Gaps.from_arrow(read_assets(require(task.gaps, "run the assets stage")), str(task.gaps))
    return Initialiser(network, task.network.parent.name, SOURCE, table, settings, gaps)
