"""Stage tune_amounts: more of DriveGen's futures of each test scenario than the pipeline makes, for tuning on many.

argv: scenarios (folder of shards), models (folder), futures (folder of shards, as many).
They begin with the first frame of a scenario, like the pipeline's own.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen.core import plugins
from drivegen.core.first_frame import first_frame
from drivegen.core.settings import Count
from drivegen.generators.base import Settings
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, require, spread

METHOD = "drivegen"


@dataclass(frozen=True)
class Params:
    """`samples`: futures of each scenario, as many as the largest of `tune.amounts`."""

    seed: int
    workers: Count
    samples: Count
    generation: Settings


@dataclass(frozen=True)
class Task:
    """One shard."""

    shard: Path
    models: Path
    out: Path
    params: Params


def main(params: Params, scenarios: Path, models: Path, out: Path) -> None:
    """Shard after shard."""
    tasks = [Task(file, models, out, params) for file in shards(require(scenarios, "run the ingest stage"))]
    for _ in spread(_generate_shard, tasks, params.workers, "tune_amounts"):
        pass


def _generate_shard(task: Task) -> None:
    scenarios = [first_frame(scenario) for scenario in read_shard(task.shard)]
    generator = plugins.load("generators", METHOD)(task.models, task.params.generation)
    write_samples(task.out / task.shard.name, generator.generate(scenarios, task.params.samples, task.params.seed))


if __name__ == "__main__":
    enter("tune_amounts", Params, main)
