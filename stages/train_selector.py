"""Stage train_selector: learn the goal selector from the train split's logs, calibrate and score it on the validation split.

argv: scenarios (folder with train and val), model (folder), metrics (JSON), loss curve (CSV). The metrics stand beside
those of a uniform choice and of the hand-made prior on the same candidates. An interrupted training goes on from
`.drivegen/checkpoints/`, in a file named after everything that it depends on. With a teacher, odds that a selector recorded for
the train split (stage goals) are the labels instead of logs.
"""

import hashlib
from dataclasses import asdict, dataclass
from pathlib import Path

from drivegen.errors import UnusableInput
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.candidates import candidates
from drivegen.goals.packing import unpack
from drivegen.goals.scores import Judged, judge, scores
from drivegen.lanes.graph import LaneGraph
from drivegen.selectors.base import Selector
from drivegen.selectors.learned import Lists, Plugin, Settings
from drivegen.selectors.prior import Plugin as Prior
from drivegen.selectors.random import Plugin as Random
from drivegen.settings import Count
from drivegen.store.files import write_json
from drivegen.store.goals import read_goals
from drivegen.store.scenarios import read_shard, shards
from drivegen.training.curve import write_curve
from stages._door import enter, require, spread_splits

CHECKPOINTS = Path(".drivegen/checkpoints")


@dataclass(frozen=True)
class Teacher:
    """Whose odds are imitated: `goals`, a folder of the goals stage for the train split, "" for logs; `name`, who chose there."""

    goals: str
    name: str

    def __post_init__(self) -> None:
        if bool(self.goals) != bool(self.name):
            raise UnusableInput("train_selector.teacher: goals and name belong together: whose odds are these?")


@dataclass(frozen=True)
class Params:
    """`candidates`: see `goals.candidates`; `learned`: see `selectors.learned`."""

    training_seed: int
    workers: Count
    candidates: CandidateSettings
    teacher: Teacher
    learned: Settings


def main(params: Params, scenarios: Path, model: Path, metrics: Path, curve: Path) -> None:
    """Learn, save, score."""
    learnt, held_out = _lists(scenarios, params)
    checkpoint = CHECKPOINTS / f"selector-{_key(learnt, held_out, params)}.safetensors"
    selector, rows = Plugin.fit(learnt, held_out, params.learned, params.training_seed, checkpoint, _say, params.teacher.name)
    selector.save(model)
    write_curve(curve, rows)
    counts = {"described": selector.described, "train_lists": len(learnt), "validation_lists": len(held_out)}
    temperature = {"temperature": float(selector.net.temperature)}
    write_json(metrics, counts | temperature | {"validation": _scores(scenarios / "val", params, selector)})
    checkpoint.unlink(missing_ok=True)


def _key(learnt: Lists, held_out: Lists, params: Params) -> str:
    """A name for everything that the weights depend on: lists, settings, seed and the code that learns."""
    digest = hashlib.sha256(repr((asdict(params.learned), params.training_seed)).encode())
    for lists in (learnt, held_out):
        for array in (lists.x, lists.distance, lists.doubt, lists.taught):
            digest.update(array.tobytes())
    root = Path(__file__).parents[1] / "drivegen"
    for path in [root / "selectors/learned.py", root / "selectors/_ranker.py", *sorted((root / "training").glob("*.py"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:24]


def _say(line: str) -> None:
    print(f"train_selector: {line}", flush=True)


def _lists(scenarios: Path, params: Params) -> tuple[Lists, Lists]:
    """Lists to learn from and held out; a teacher says what to learn, never what is held out."""

    def tasks(split: Path) -> list[tuple[Path, CandidateSettings, str]]:
        teacher = params.teacher.goals if split.name == "train" else ""
        return [(shard, params.candidates, teacher) for shard in shards(split)]

    learnt, held_out = spread_splits(_shard_lists, scenarios, tasks, params.workers, "goals")
    return Lists.joined([Lists.none(), *learnt]), Lists.joined([Lists.none(), *held_out])


def _shard_lists(task: tuple[Path, CandidateSettings, str]) -> Lists:
    shard, settings, teacher = task
    if teacher:
        return _taught_lists(shard, require(Path(teacher) / shard.name, "run the goals stage on the train split"))
    return Lists.joined([Lists.none(), *(Lists.of_log(log, settings) for log in read_shard(shard))])


def _taught_lists(shard: Path, recorded: Path) -> Lists:
    """Lists of a shard with the odds recorded for it. Raises UnusableInput where they belong to other scenarios."""
    scenarios, goals = read_shard(shard), read_goals(recorded)
    if [s.scenario_id for s in scenarios] != [g.scenario_id for g in goals]:
        raise UnusableInput(f"{recorded} belongs to other scenarios than {shard}: run the goals stage again")
    parts = [Lists.none()]
    for scenario, columns in zip(scenarios, goals, strict=True):
        parts.append(Lists.by_teacher(scenario, *unpack(LaneGraph.of(scenario.map), columns)))
    return Lists.joined(parts)


def _scores(split: Path, params: Params, selector: Plugin) -> dict[str, dict[str, dict[str, float]]]:
    """Scores of the learned, the prior and the uniform choice."""
    compared: dict[str, Selector] = {"learned": selector, "prior": Prior(), "random": Random()}
    judged: dict[str, list[Judged]] = {name: [] for name in compared}
    for shard in shards(split):
        for scenario in read_shard(shard):
            graph = LaneGraph.of(scenario.map)
            offered = [candidates(graph, scenario, n, params.candidates) for n in range(len(scenario.vehicles))]
            for name, each in compared.items():
                judged[name].append(judge(scenario, offered, each.rank(graph, scenario, offered)))
    return {name: scores(Judged.joined(parts)) for name, parts in judged.items()}


if __name__ == "__main__":
    enter("train_selector", Params, main)
