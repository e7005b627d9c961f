"""Stage goals@<selector>: candidate goals of every vehicle and their probabilities, shard for shard.

argv: scenarios (folder of shards), the trained selector (folder), goals (folder; its name is the selector's), metrics
(JSON). Coverage and ranking are scored where scenarios have a log.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen import plugins
from drivegen.goals.candidates import Settings, candidates
from drivegen.goals.packing import pack
from drivegen.goals.scores import Judged, judge, scores
from drivegen.lanes.graph import LaneGraph
from drivegen.store.files import write_json
from drivegen.store.goals import write_goals
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, require, spread


@dataclass(frozen=True)
class Params:
    """`candidates`: see `goals.candidates`."""

    workers: int
    candidates: Settings


@dataclass(frozen=True)
class Task:
    """One shard to be done by one selector."""

    shard: Path
    model: Path
    goals: Path
    settings: Settings


def main(params: Params, scenarios: Path, model: Path, goals: Path, metrics: Path) -> None:
    """Find, rank, write, score."""
    described = plugins.load("selectors", goals.name).described
    tasks = [Task(shard, model, goals, params.candidates) for shard in shards(require(scenarios, "run the ingest stage"))]
    done = spread(_shard_goals, tasks, params.workers, f"goals by {goals.name}")
    judged = Judged.joined([part for _, part in done])
    write_json(metrics, {"selector": goals.name, "described": described, **scores(judged)})


def _shard_goals(task: Task) -> Judged:
    selector = plugins.load("selectors", task.goals.name).load(task.model)
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
