"""Stage recall: where some goal of one vehicle makes a driver fail, how much of that adversaries find, in how many runs.

argv: scenarios of one split, models, recorded goals of one selector, traffic as it is (folder of shards), results (JSON, a
list of rows {driver, method, queries, metric, value, low, high, n}). Neighbours are replayed.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import Adversary
from drivegen.adversaries.shared.arena import Arena, Bounds
from drivegen.adversaries.shared.recall import EVERY, VARIED, Recall
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.seeds import rng
from drivegen.core.settings import Count, Index
from drivegen.store.files import write_json
from stages._door import build, spread
from stages._ground import Made, shares


@dataclass(frozen=True)
class Params:
    """Section `recall`.

    Attributes:
        planner: fills in motion. scenes: of all shards, one of each scenario. motions: towards each goal, of what there is.
        allowed: of `adversaries.shared.rules.RULES`. queries: runs after which it is counted what has been found.
        reaction_steps: others avoid the target's plan for so many steps. draws: bootstrap draws behind intervals.
        variants: settings of DriveGen-CS, each with something left out or added, by what that is.
    """

    seed: int
    workers: Count
    planner: str
    scenes: Count
    motions: Count
    allowed: str
    queries: list[Count]
    reaction_steps: Index
    drivers: dict[str, dict[str, Any]]
    adversaries: dict[str, dict[str, Any]]
    variants: dict[str, dict[str, Any]]
    draws: Count

    def __post_init__(self) -> None:
        if not self.queries:
            raise UnusableInput("stages/params.yaml: recall.queries: name at least one number of runs")

    def searching(self) -> dict[str, Adversary]:
        """All that search, a variant by `drivegen_cs.<name>`."""
        place, own, made = "recall.adversaries", plugins.load("adversaries", VARIED), dict[str, Adversary]()
        for name in self.adversaries:
            made[name] = plugins.make("adversaries", name, self.adversaries, place)
        for name, settings in self.variants.items():
            made[f"{VARIED}.{name}"] = own(build(own.settings_type, settings, f"stages/params.yaml: recall.variants.{name}"))
        return made


@dataclass(frozen=True)
class Task:
    """So many `scenes` of a shard, by one driver."""

    driver: str
    shard: Path
    scenes: int
    models: Path
    goals: Path
    traffic: Path
    params: Params


def main(params: Params, scenarios: Path, models: Path, goals: Path, traffic: Path, results: Path) -> None:
    """Every driver, shard by shard."""
    share = shares(scenarios, params.scenes)
    tasks = [Task(driver, *part, models, goals, traffic, params) for driver in params.drivers for part in share]
    parts: dict[str, list[Recall]] = {}
    for task, recall in spread(_searched, tasks, params.workers, "recall"):
        parts.setdefault(task.driver, []).append(recall)
    write_json(results, [{"driver": name, **row} for name, own in parts.items() for row in _rows(Recall.joined(own), params)])


def _searched(task: Task) -> Recall:
    params = task.params
    ground = Made.open(task.models, params.planner, task.goals, task.traffic).ground(task.shard, 1, task.scenes)
    bounds = Bounds(params.allowed, max(params.queries), params.reaction_steps)
    driver = plugins.make("drivers", task.driver, params.drivers, "recall.drivers")
    return Recall.of(Arena(driver, ground, bounds, params.seed), params.searching(), params.motions)


def _rows(recall: Recall, params: Params) -> Iterator[dict[str, Any]]:
    """`counted` and `avoidable` are shares of all scenarios, `recall` of those that are open."""
    whole = np.ones(len(recall.open), np.bool_)
    yield {"method": EVERY, "queries": None, "metric": "counted", **_mean(recall.open, whole, recall, params)}
    for method, search in recall.searches.items():
        for queries in params.queries:
            hit = search.first <= queries
            shares = {"counted": (hit, whole), "avoidable": (search.avoidable <= queries, whole), "recall": (hit, recall.open)}
            for metric, (values, among) in shares.items():
                yield {"method": method, "queries": queries, "metric": metric, **_mean(values, among, recall, params)}


def _mean(values: NDArray[np.bool_], among: NDArray[np.bool_], recall: Recall, params: Params) -> dict[str, Any]:
    """The share of `values` (C,) where `among` (C,) holds, with its interval over recordings."""
    rows = np.flatnonzero(among)
    recordings, random = [recording(recall.scenarios[r]) for r in rows.tolist()], rng(params.seed, "recall", "bootstrap")
    [interval] = bootstrap_means(values[rows, None].astype(np.float64), recordings, params.draws, random)
    return {**asdict(interval), "n": len(rows)}
