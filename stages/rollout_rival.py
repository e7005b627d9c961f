"""Stage rollout_rival@<name>: K futures of every test scenario by a trained generator to compare with, each judged.

argv: scenarios (folder of shards), models (folder), generated (folder; its name is the rival's). As stage rollout, but
rivals know neither goals nor planners, so nothing of DriveGen's own but the checker can change what stands here.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen import plugins
from drivegen.generators._learned import Learned
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
    """One shard by one rival."""

    shard: Path
    models: Path
    out: Path
    params: Params


def main(params: Params, scenarios: Path, models: Path, generated: Path) -> dict[str, float]:
    """Generate and judge shard after shard."""
    tasks = [Task(shard, models, generated, params) for shard in shards(require(scenarios, "run the ingest stage"))]
    made = [count for _, count in spread(_generate_shard, tasks, params.workers, f"rollout {generated.name}")]
    return {"scenarios": float(sum(made))}


def _generate_shard(task: Task) -> int:
    scenarios = read_shard(task.shard)
    generator: Learned = plugins.load("generators", task.out.name)(task.models, None)
    limits = read_limits(task.models)
    made = generator.generate(scenarios, task.params.samples, task.params.seed)
    write_samples(task.out / task.shard.name, [judged(s, m, limits) for s, m in zip(scenarios, made, strict=True)])
    return len(scenarios)


if __name__ == "__main__":
    enter("rollout_rival", Params, main)
