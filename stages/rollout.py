"""Stage rollout@<method>: K futures of every test scenario by DriveGen or an ablation of it, which follow recorded goals.

argv: scenarios (folder of shards), models (folder), recorded goals (folder of folders, one a selector), generated
(folder; its name is the method's). Nobody is dropped: what stays illegal is kept and counted as illegal.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen import plugins
from drivegen.errors import UnusableInput
from drivegen.generators.base import Settings
from drivegen.settings import Count
from drivegen.store.goals import read_goals
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, require, spread


@dataclass(frozen=True)
class Params:
    """`samples`: futures of each scenario. `generation`: see `generators.base.Settings`."""

    seed: int
    workers: Count
    samples: Count
    generation: Settings


@dataclass(frozen=True)
class Task:
    """One shard by one method."""

    shard: Path
    models: Path
    goals: Path
    out: Path
    params: Params


def main(params: Params, scenarios: Path, models: Path, goals: Path, generated: Path) -> None:
    """Generate and judge shard after shard."""
    tasks = [Task(shard, models, goals, generated, params) for shard in shards(require(scenarios, "run the ingest stage"))]
    for _ in spread(_generate_shard, tasks, params.workers, f"rollout {generated.name}"):
        pass


def _generate_shard(task: Task) -> None:
    scenarios = read_shard(task.shard)
    params = task.params
    generator = plugins.load("generators", task.out.name)(task.models, params.generation)
    if generator.selector is None:
        raise UnusableInput(f"generator {task.out.name!r} knows no goals: put it into run.baselines of params.yaml, not run.own")
    recorded = read_goals(require(task.goals / generator.selector / task.shard.name, "run the goals stage"))
    samples = generator.follow(scenarios, recorded, params.samples, params.seed)
    write_samples(task.out / task.shard.name, samples)


if __name__ == "__main__":
    enter("rollout", Params, main)
