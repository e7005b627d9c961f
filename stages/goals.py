"""Stage goals@<selector>: candidate goals of every vehicle and their probabilities, shard for shard.

argv: scenarios (folder of shards), the trained selector (folder), goals (folder; its name is the selector's), results (Parquet
rows), metrics (JSON). Coverage and ranking are scored where scenarios have a log. Where a language model is asked (`vlm`), what
it will cost is told before the first call, in batches (lm.goals.batch) a shard is one, and its calls are rows of
.drivegen/calls/goals*.parquet.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count
from drivegen.goals.candidates import Candidates, Settings, candidates
from drivegen.goals.packing import pack
from drivegen.goals.scores import Judged, judge, scene_scores, scores
from drivegen.lm.model import LanguageModel
from drivegen.lm.settings import RecordSettings, RoleSettings
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.base import Selector
from drivegen.selectors.vlm import Plugin as AskingSelector
from drivegen.selectors.vlm import Settings as AskingSettings
from drivegen.store.files import write_json
from drivegen.store.goals import write_goals
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.scenarios import count, read_shard, shards
from stages._door import read_params, require, spread

_SCENES = 3  # whose questions are really made for the forecast of what calls will cost


@dataclass(frozen=True)
class Params:
    """`candidates`: see `goals.candidates`; `vlm`: see `selectors.vlm`; `draws`: of the bootstrap behind intervals."""

    seed: int
    workers: Count
    draws: Count
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


def main(params: Params, scenarios: Path, model: Path, goals: Path, results: Path, metrics: Path) -> None:
    """Find, rank, write, score."""
    selector: Selector = plugins.load("selectors", goals.name).load(model)
    files = shards(require(scenarios, "run the ingest stage"))
    asking: dict[str, Any] = {}
    if isinstance(selector, AskingSelector):
        lm = LanguageModel("goals", read_params("lm.goals", RoleSettings), read_params("lm.records", RecordSettings).open())
        selector = AskingSelector.asking(model, lm, params.vlm, params.seed)
        print(_forecast(files, selector, lm, params.candidates), flush=True)
        tasks = [Task(shard, model, goals, params.candidates, selector) for shard in files]
        with lm.ledger.kept("goals"):
            done = list(spread(_shard_goals, tasks, 1, f"goals by {goals.name}"))  # one budget, one list of calls
        asking = {"asking": selector.account.table()}
    else:
        tasks = [Task(shard, model, goals, params.candidates, None) for shard in files]
        done = list(spread(_shard_goals, tasks, params.workers, f"goals by {goals.name}"))
    judged = Judged.joined([part for _, part in done])
    run = Run.of(
        "goals", goals.name, asdict(params), [scenarios, *([model] if model.exists() else [])], backend=selector.described
    )
    write_results(results, [result_rows(run, *scene_scores(judged))])
    about = {"selector": goals.name, "described": selector.described, **asking}
    write_json(metrics, about | scores(judged, params.seed, params.draws))


def _forecast(files: list[Path], selector: AskingSelector, model: LanguageModel, settings: Settings) -> str:
    """What the calls will cost, from the questions about the first scenes."""
    total = sum(map(count, files))
    first = [_offered(first_frame(scenario), settings) for scenario in read_shard(files[0])[:_SCENES]]
    return model.forecast(*selector.questions(first), total / max(len(first), 1))


def _offered(scenario: Scenario, settings: Settings) -> tuple[LaneGraph, Scenario, list[Candidates]]:
    graph = LaneGraph.of(scenario.map)
    return graph, scenario, [candidates(graph, scenario, n, settings) for n in range(len(scenario.vehicles))]


def _shard_goals(task: Task) -> Judged:
    selector = task.selector or plugins.load("selectors", task.goals.name).load(task.model)
    packed, judged = [], []
    scenarios = read_shard(task.shard)
    shown = scenarios if selector.reads_log else [first_frame(scenario) for scenario in scenarios]
    if isinstance(selector, AskingSelector) and selector.in_batches:
        selector.ahead([_offered(scene, task.settings) for scene in shown])
    for scenario, scene in zip(scenarios, shown, strict=True):
        graph, _, offered_places = _offered(scene, task.settings)
        offered = selector.offer(graph, scene, offered_places)
        probabilities = selector.rank(graph, scene, offered)
        packed.append(pack(scenario, task.goals.name, offered, probabilities))
        judged.append(judge(scenario, offered, probabilities))
    write_goals(task.goals / task.shard.name, packed)
    return Judged.joined(judged)
