"""Stage goal_lists: what goal selectors learn from - each logged vehicle's candidates as features, with where it ended.

argv: scenarios (folder with train and val), out (folder): train.parquet and val.parquet, a row a vehicle. They are a stage of
their own because no training seed changes them, and they take longer than to learn from them. With a teacher, odds that a
selector recorded for the train split (stage goals) are the labels of train.parquet instead of the logs'.
"""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.list_files import list_writer
from drivegen.goals.lists import Lists
from drivegen.goals.packing import unpack
from drivegen.roads.graph import LaneGraph
from drivegen.store.columns import joined
from drivegen.store.folders import whole_folder
from drivegen.store.goals import read_goals
from drivegen.store.scenarios import read_shard, shards
from stages._door import require, spread_splits


@dataclass(frozen=True)
class Teacher:
    """Whose odds are imitated: `goals`, a folder of the goals stage for the train split, "" for logs; `name`, who chose there."""

    goals: str
    name: str

    def __post_init__(self) -> None:
        if bool(self.goals) != bool(self.name):
            raise UnusableInput("goal_lists.teacher: goals and name belong together: whose odds are these?")


@dataclass(frozen=True)
class Params:
    """`candidates`: see `goals.candidates`."""

    workers: Count
    candidates: CandidateSettings
    teacher: Teacher


def main(params: Params, scenarios: Path, out: Path) -> dict[str, float]:
    """Make and write; a teacher says what to learn, never what is held out."""

    def tasks(split: Path) -> list[tuple[Path, CandidateSettings, str]]:
        teacher = params.teacher.goals if split.name == "train" else ""
        return [(shard, params.candidates, teacher) for shard in shards(split)]

    count = 0
    with whole_folder(out) as folder, ExitStack() as files:
        teachers = {"train": params.teacher.name, "val": ""}
        write = {split: files.enter_context(list_writer(folder / f"{split}.parquet", who)) for split, who in teachers.items()}
        for split, lists in spread_splits(_shard_lists, scenarios, tasks, params.workers, "goal lists"):
            write[split](lists)
            count += len(lists)
        files.close()  # before the folder takes its place
    return {"lists": float(count)}


def _shard_lists(task: tuple[Path, CandidateSettings, str]) -> Lists:
    shard, settings, teacher = task
    if teacher:
        return _taught_lists(shard, require(Path(teacher) / shard.name, "run the goals stage on the train split"))
    return joined(Lists, (Lists.of_log(log, settings) for log in read_shard(shard)))


def _taught_lists(shard: Path, recorded: Path) -> Lists:
    """Lists of a shard with the odds recorded for it. Raises UnusableInput where they belong to other scenarios."""
    scenarios, goals = read_shard(shard), read_goals(recorded)
    if [s.scenario_id for s in scenarios] != [g.scenario_id for g in goals]:
        raise UnusableInput(f"{recorded} belongs to other scenarios than {shard}: run the goals stage again")
    pairs = zip(scenarios, goals, strict=True)
    return joined(
        Lists, (Lists.by_teacher(scenario, *unpack(LaneGraph.of(scenario.map), columns)) for scenario, columns in pairs)
    )
