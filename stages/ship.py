"""Stage ship: the data set that leaves the house: DriveGen's traffic on new maps, legal as a whole, in shards.

argv: new scenarios (folder of shards, no logs), models (folder), shipped (folder of shards), counts (JSON).
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from drivegen.core import plugins
from drivegen.core.settings import Count
from drivegen.generators.base import Settings
from drivegen.rollout.shipping import ShipSettings, ship
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards, write_shard
from stages._door import enter, require, spread


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


def main(params: Params, scenarios: Path, models: Path, shipped: Path, counts: Path) -> dict[str, float]:
    """Generate, keep what is legal, count the rest."""
    tasks = [Task(shard, models, shipped, params) for shard in shards(require(scenarios, "run the place stage"))]
    total: Counter[str] = Counter()
    for _, part in spread(_ship_shard, tasks, params.workers, "ship"):
        total += part
    write_json(counts, {"method": params.method, **total})
    print(f"ship: {total['shipped']} of {total['asked']} scenarios, {total['vehicles.dropped']} vehicles left out")
    return {"scenarios": float(total["shipped"])}


def _ship_shard(task: Task) -> Counter[str]:
    params, counts = task.params, Counter[str]()
    scenarios = read_shard(task.shard)
    generator = plugins.load("generators", params.method)(task.models, params.generation)
    made = generator.generate(scenarios, params.samples, params.seed)
    kept = [
        s for scenario, samples in zip(scenarios, made, strict=True) for s in ship(scenario, samples, params.settings, counts)
    ]
    write_shard(task.out / task.shard.name, kept)
    return counts


if __name__ == "__main__":
    enter("ship", Params, main)
