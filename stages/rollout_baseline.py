"""Stage rollout_baseline@<name>: K futures of every test scenario by a generator that learns nothing, each judged.

argv: scenarios (folder of shards), models (folder), generated (folder; its name is the generator's). Only the legal checker's
limits are taken of the models: nothing that is trained can change what stands here.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen import plugins
from drivegen.errors import UnusableInput
from drivegen.settings import Count
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, shards
from drivegen.verdicts import judged, read_limits
from stages._door import enter, require, spread


@dataclass(frozen=True)
class Params:
    """`samples`: futures of each scenario, as many as of every method."""

    seed: int
    workers: Count
    samples: Count


@dataclass(frozen=True)
class Task:
    """One shard by one generator."""

    shard: Path
    models: Path
    out: Path
    params: Params


def main(params: Params, scenarios: Path, models: Path, generated: Path) -> None:
    """Generate and judge shard after shard."""
    tasks = [Task(shard, models, generated, params) for shard in shards(require(scenarios, "run the ingest stage"))]
    for _ in spread(_generate_shard, tasks, params.workers, f"rollout {generated.name}"):
        pass


def _generate_shard(task: Task) -> None:
    name, scenarios = task.out.name, read_shard(task.shard)
    plugin = plugins.load("generators", name)
    if plugin.selector is not None:
        raise UnusableInput(f"generator {name!r} follows goals: put it into run.own of params.yaml, not run.baselines")
    limits = read_limits(task.models)
    made = plugin(task.models, None).generate(scenarios, task.params.samples, task.params.seed)
    write_samples(task.out / task.shard.name, [judged(s, m, limits) for s, m in zip(scenarios, made, strict=True)])


if __name__ == "__main__":
    enter("rollout_baseline", Params, main)
