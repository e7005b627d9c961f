"""Stage rollout@<method>: K futures of every test scenario by DriveGen or an ablation of it, which follow recorded goals.

argv: scenarios (folder of shards), models (folder), recorded goals (folder of folders, one a selector), generated
(folder; its name is the method's), rejected (file: what the checker turned down on the way, in the scenes that the report
shows). Planner and checker know the first frame; the log reaches them only by goals that were recorded from it (a bound).
Nobody is dropped: what stays illegal is kept and counted as illegal.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.rejections import Rejected, Rejections
from drivegen.core.settings import Count, Index
from drivegen.generators.base import Settings
from drivegen.store.draw import draw_places
from drivegen.store.goals import read_goals
from drivegen.store.rejected import write_rejected
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import require, spread


@dataclass(frozen=True)
class Params:
    """`samples`: futures of each scenario. `generation`: see `generators.base.Settings`.

    `rejected`: scenes, the first that pictures draw (`store.draw`, by `seed`), of which is kept what was turned down.
    """

    seed: int
    sampling_seed: int
    workers: Count
    samples: Count
    rejected: Index
    generation: Settings


@dataclass(frozen=True)
class Task:
    """One shard by one method; `shown` are the rows of which is kept what was turned down."""

    shard: Path
    models: Path
    goals: Path
    out: Path
    params: Params
    shown: tuple[int, ...]


def main(params: Params, scenarios: Path, models: Path, goals: Path, generated: Path, rejected: Path) -> None:
    """Generate and judge shard after shard."""
    files = shards(require(scenarios, "run the ingest stage"))
    places = draw_places(params.seed, scenarios, params.rejected)
    tasks = [Task(file, models, goals, generated, params, tuple(row for at, row in places if at == file)) for file in files]
    rejections: dict[tuple[Path, int], Rejected] = {}
    for task, rejected_of_shard in spread(_generate_shard, tasks, params.workers, f"rollout {generated.name}"):
        rejections |= {(task.shard, row): one for row, one in zip(task.shown, rejected_of_shard, strict=True)}
    write_rejected(rejected, [rejections[place] for place in places])


def _generate_shard(task: Task) -> list[Rejected]:
    """What was turned down in the rows `task.shown`."""
    scenarios = [first_frame(scenario) for scenario in read_shard(task.shard)]
    params = task.params
    generator = plugins.load("generators", task.out.name)(task.models, params.generation)
    if generator.about.goals is None:
        raise UnusableInput(f"generator {task.out.name!r} knows no goals: put it into run.baselines of params.yaml, not run.own")
    recorded = read_goals(require(task.goals / generator.about.goals / task.shard.name, "run the goals stage"))
    rejections = {scenarios[row].scenario_id: Rejections() for row in task.shown}
    samples = generator.follow(scenarios, recorded, params.samples, params.sampling_seed, rejections)
    write_samples(task.out / task.shard.name, samples)
    return [rejections[samples[row].scenario_id].replaced_in(samples[row]) for row in task.shown]
