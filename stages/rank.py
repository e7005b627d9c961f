"""Stage rank: how sound and mutated drivers do in logged and in generated traffic, neighbours replayed.

argv: scenarios of one split, generated samples (a folder a method), weights of taught drivers, results (Parquet rows: of every
driver in every scenario the share of its runs that end in a counted collision, and of those that come near one).
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.core import plugins
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import Count
from drivegen.drivers.base import Driver
from drivegen.drivers.mutants.table import mutated
from drivegen.metrics.near_miss import near_misses
from drivegen.store.lookup import futures_in, logs_in
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.scenarios import shards
from stages._door import require, spread

LOG = "log"
SIMULATOR = "batch"

Numbers = dict[str, dict[str, NDArray[np.float64]]]
"""By driver and metric, (S,)."""


@dataclass(frozen=True)
class Params:
    """`methods`: whose samples are driven beside the log, the first `samples` of each; `drivers`: the sound ones' settings."""

    seed: int
    workers: Count
    methods: tuple[str, ...]
    samples: Count
    drivers: dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Task:
    """One shard in one method's traffic."""

    shard: Path
    samples: Path | None
    params: Params


def main(params: Params, scenarios: Path, generated: Path, weights: Path, results: Path) -> dict[str, float]:
    """Every driver through every method's traffic."""
    files = shards(require(scenarios, "run the ingest stage"))
    tables: list[pa.Table] = []
    runs = 0
    for method in (LOG, *params.methods):
        folder = None if method == LOG else require(generated / method, "run the rollout stages")
        inputs = [scenarios, weights, *([folder] if folder else [])]
        tasks = [Task(file, folder and folder / file.name, params) for file in files]
        for _, (ids, numbers, driven) in spread(_drive_shard, tasks, params.workers, f"rank {method}"):
            runs += driven
            for driver, metrics in numbers.items():
                run = Run.of("rank", results.stem, asdict(params), inputs, method=method, driver=driver, backend=SIMULATOR)
                tables.append(result_rows(run, ids, metrics))
    write_results(results, tables)
    return {"runs": float(runs)}


def _drive_shard(task: Task) -> tuple[list[str], Numbers, int]:
    """The scenarios, what each driver did in them, and how many runs that were."""
    pairs = _traffic(task)
    ids = list(dict.fromkeys(scenario.scenario_id for scenario, _ in pairs))
    scene = np.array([ids.index(scenario.scenario_id) for scenario, _ in pairs], np.intp)
    if not ids:
        return [], {}, 0
    scenarios, traffic = [scenario for scenario, _ in pairs], [motion for _, motion in pairs]
    drivers = _drivers(task.params)
    outcomes = plugins.load("simulators", SIMULATOR)().run_each(list(drivers.values()), scenarios, traffic)
    numbers: Numbers = {}
    for name, outcome in zip(drivers, outcomes, strict=True):
        happened = {
            "counted": outcome.counted,
            "near_miss": near_misses(outcome.motion, scenarios, traffic) | outcome.counted,
            "collision": outcome.collided,
        }
        numbers[name] = {metric: np.bincount(scene, value) / np.bincount(scene) for metric, value in happened.items()}
    return ids, numbers, len(pairs) * len(drivers)


def _traffic(task: Task) -> list[tuple[Scenario, Trajectories]]:
    if task.samples is None:
        return logs_in(task.shard)
    futures = futures_in(task.samples, task.shard.parent)
    return [(one, samples.motion[k]) for one, samples in futures for k in range(min(task.params.samples, len(samples.dropped)))]


def _drivers(params: Params) -> dict[str, Driver]:
    """The sound drivers, then what the table of mutations makes of them."""
    sound: dict[str, Driver] = {name: plugins.make("drivers", name, params.drivers, "rank.drivers") for name in params.drivers}
    return {**sound, **mutated(sound)}
