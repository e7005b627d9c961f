"""Stage goals@<selector>: candidate goals of every vehicle and their probabilities, shard for shard.

argv: scenarios (folder of shards), the trained selector (folder), goals (folder; its name is the selector's), metrics
(JSON). Coverage and ranking are scored where scenarios have a log. Where a language model is asked (`vlm`), its calls are rows of
.drivegen/calls/goals.parquet.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen import plugins
from drivegen.goals.candidates import Settings, candidates
from drivegen.goals.packing import pack
from drivegen.goals.scores import Judged, judge, scores
from drivegen.lanes.graph import LaneGraph
from drivegen.lm.model import LanguageModel
from drivegen.lm.settings import RecordSettings, RoleSettings
from drivegen.selectors.base import Selector
from drivegen.selectors.vlm import Plugin as AskingSelector
from drivegen.selectors.vlm import Settings as AskingSettings
from drivegen.store.files import write_json
from drivegen.store.goals import write_goals
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, read_params, require, spread

CALLS = Path(".drivegen/calls/goals.parquet")


@dataclass(frozen=True)
class Params:
    """`candidates`: see `goals.candidates`; `vlm`: see `selectors.vlm`; `draws`: of the bootstrap behind intervals."""

    seed: int
    workers: int
    draws: int
    candidates: Settings
    vlm: AskingSettings


@dataclass(frozen=True)
class Task:
    """One shard to be done by one selector; `selector` is opened from `model` where it is None."""

    shard: Path
    model: Path
    goals: Path
    settings: Settings
    selector: Selector | None


def main(params: Params, scenarios: Path, model: Path, goals: Path, metrics: Path) -> None:
    """Find, rank, write, score."""
    selector: Selector = plugins.load("selectors", goals.name).load(model)
    asked: dict[str, Any] = {}
    if isinstance(selector, AskingSelector):
        lm = LanguageModel("goals", read_params("lm.goals", RoleSettings), read_params("lm.records", RecordSettings).open())
        selector = AskingSelector.asking(model, lm, params.vlm, params.seed)
    in_one = selector if isinstance(selector, AskingSelector) else None  # one budget, one list of calls
    found = shards(require(scenarios, "run the ingest stage"))
    tasks = [Task(shard, model, goals, params.candidates, in_one) for shard in found]
    done = spread(_shard_goals, tasks, 1 if in_one else params.workers, f"goals by {goals.name}")
    judged = Judged.joined([part for _, part in done])
    if in_one:
        lm.ledger.write(CALLS)
        asked = {"asking": in_one.account.table()}
    told = {"selector": goals.name, "described": selector.described, **asked}
    write_json(metrics, told | scores(judged, params.seed, params.draws))


def _shard_goals(task: Task) -> Judged:
    selector = task.selector or plugins.load("selectors", task.goals.name).load(task.model)
    packed, judged = [], []
    for scenario in read_shard(task.shard):
        graph = LaneGraph.of(scenario.map)
        found = [candidates(graph, scenario, n, task.settings) for n in range(len(scenario.vehicles))]
        offered = selector.offer(graph, scenario, found)
        probabilities = selector.rank(graph, scenario, offered)
        packed.append(pack(scenario.scenario_id, task.goals.name, offered, probabilities))
        judged.append(judge(scenario, offered, probabilities))
    write_goals(task.goals / task.shard.name, packed)
    return Judged.joined(judged)


if __name__ == "__main__":
    enter("goals", Params, main)
