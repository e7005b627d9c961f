"""Stage mutation_score: which mutated drivers traffic and adversaries tell from the sound ones, in how many runs.

argv: scenarios of one split, generated samples (a folder a method), models, recorded goals of one selector, samples in which
adversaries search (folder of shards), results (Parquet rows, sums of every scenario), scores (JSON).
"""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from drivegen.adversaries.shared.arena import Bounds
from drivegen.adversaries.shared.testers import by_search, by_traffic
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.seeds import rng
from drivegen.core.settings import Count, Index
from drivegen.drivers.mutants.table import MUTATIONS, Mutant, mutated
from drivegen.metrics.mutation_score import Pairs, Settings, scored
from drivegen.store.files import write_json
from drivegen.store.lookup import in_turn
from drivegen.store.results import Run, result_rows, write_results
from stages._door import require, spread
from stages._ground import Made, shares

LOG = "log"


@dataclass(frozen=True)
class Params:
    """Attributes:
    methods: whose traffic is a tester, beside the log. adversaries: settings of who searches; drivers: of the sound ones.
    runs: of each mutated driver, by every tester, at most; of these `queries` in a scenario where a tester searches, in its
        first `samples` scenes. planner, allowed, reaction_steps: as in `attack`. test: when a driver is killed.
    """

    seed: int
    workers: Count
    methods: tuple[str, ...]
    adversaries: dict[str, dict[str, Any]]
    drivers: dict[str, dict[str, Any]]
    runs: Count
    queries: Count
    samples: Count
    planner: str
    allowed: str
    reaction_steps: Index
    test: Settings


@dataclass(frozen=True)
class Task:
    """`runs` of each driver at most, in one shard by one tester; `traffic` (None: logs) and `goals` are folders of shards."""

    tester: str
    shard: Path
    runs: int
    traffic: Path | None
    goals: Path
    models: Path
    params: Params


def main(
    params: Params, scenarios: Path, generated: Path, models: Path, goals: Path, traffic: Path, results: Path, scores: Path
) -> dict[str, float]:
    """Every tester tests every mutated driver."""
    share = shares(scenarios, params.runs)
    tables, numbers = [], {}
    for tester in (LOG, *params.methods, *params.adversaries):
        folder = None if tester == LOG else traffic if tester in params.adversaries else generated / tester
        searched = [goals] if tester in params.adversaries else []
        inputs = [scenarios, models, *searched, *([require(folder, "run the rollout and corner stages")] if folder else [])]
        tasks = [Task(tester, file, runs, folder, goals, models, params) for file, runs in share]
        parts = [part for _, part in spread(_test, tasks, params.workers, f"mutation score of {tester}") if part]
        if not parts:
            raise UnusableInput(f"{tester} has nothing to drive in {scenarios}, or mutation_score.runs is too small for it")
        pairs = {name: Pairs.joined([part[name] for part in parts]) for name in parts[0]}
        fails = {name: MUTATIONS[name].fails for name in pairs}
        numbers[tester] = scored(pairs, fails, params.test, rng(params.seed, "mutation", tester))
        run = Run.of("mutation_score", results.stem, asdict(params), inputs, method=tester, backend="batch")
        tables += [result_rows(replace(run, driver=name), *each.by_scenario()) for name, each in pairs.items()]
    write_results(results, tables)
    write_json(scores, numbers)
    return {"runs": float(sum(each["runs"] for score in numbers.values() for each in score["drivers"].values()))}


def _test(task: Task) -> dict[str, Pairs]:
    params = task.params
    sound = {name: plugins.make("drivers", name, params.drivers, "mutation_score.drivers") for name in params.drivers}
    if task.tester in params.adversaries:
        return _searched(task, mutated(sound))
    chosen = in_turn(task.shard, task.traffic and task.traffic / task.shard.name, task.runs)
    return by_traffic(mutated(sound), *zip(*chosen, strict=True)) if chosen else {}


def _searched(task: Task, mutants: dict[str, Mutant]) -> dict[str, Pairs]:
    """As many scenarios, spread over the shard, as runs last for."""
    params, most = task.params, task.runs // task.params.queries
    if not most or task.traffic is None:
        return {}
    ground = Made.open(task.models, params.planner, task.goals, task.traffic).ground(task.shard, params.samples, most)
    adversary = plugins.make("adversaries", task.tester, params.adversaries, "mutation_score.adversaries")
    bounds = Bounds(params.allowed, params.queries, params.reaction_steps)
    return dict(by_search(mutants, adversary, ground, bounds, params.seed))
