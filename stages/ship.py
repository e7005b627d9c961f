"""Stage ship: the data set that leaves the house: DriveGen's traffic on new maps, legal as a whole, in shards.

argv: new scenarios (folder of shards, no logs), models (folder), shipped (folder of shards), results (Parquet rows), counts
(JSON).
"""

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from drivegen.core import plugins
from drivegen.core.settings import Count
from drivegen.generators.base import Settings
from drivegen.rollout.shipping import ShipSettings, fates, ship
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.scenarios import read_shard, shards, write_shard
from stages._door import require, spread


@dataclass(frozen=True)
class Params:
    """`method`: the generator. `samples`: futures of each new scenario. `generation`, `settings`: see their classes."""

    seed: int
    workers: Count
    method: str
    samples: Count
    generation: Settings
    settings: ShipSettings


@dataclass(frozen=True)
class Task:
    """One shard."""

    shard: Path
    models: Path
    out: Path
    params: Params
    run: Run


def main(params: Params, scenarios: Path, models: Path, shipped: Path, results: Path, counts: Path) -> dict[str, float]:
    """Generate, keep what is legal, count the rest."""
    files = shards(require(scenarios, "run the place stage"))
    read = [scenarios, models / "planners" / params.generation.planner, models / "selector", models / "limits.json"]
    run = Run.of("ship", counts.stem, asdict(params), read, method=params.method)
    tasks = [Task(shard, models, shipped, params, run) for shard in files]
    total: Counter[str] = Counter()
    tables = []
    for _, (part, rows) in spread(_ship_shard, tasks, params.workers, "ship"):
        total += part
        tables.append(rows)
    write_results(results, tables)
    write_json(counts, {"method": params.method, **total})
    print(f"ship: {total['shipped']} of {total['asked']} scenarios, {total['vehicles.dropped']} vehicles left out")
    return {"scenarios": float(total["shipped"])}


def _ship_shard(task: Task) -> tuple[Counter[str], pa.Table]:
    params, counts = task.params, Counter[str]()
    scenarios = read_shard(task.shard)
    generator = plugins.load("generators", params.method)(task.models, params.generation)
    futures = generator.generate(scenarios, params.samples, params.seed)
    shipped = [
        s for scenario, samples in zip(scenarios, futures, strict=True) for s in ship(scenario, samples, params.settings, counts)
    ]
    write_shard(task.out / task.shard.name, shipped)
    rows = [
        result_rows(task.run, [one.scenario_id] * params.samples, fates(one, params.settings), np.arange(params.samples))
        for one in futures
    ]
    return counts, pa.concat_tables(rows)
