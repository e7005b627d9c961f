"""Stage attack@<driver>: every adversary looks for collisions of one driver, in the same scenes, with at most as many runs.

argv: scenarios (folder of shards), models, recorded goals of one selector, samples that are the traffic (folder of shards),
cases (folder), results (Parquet rows), metrics (JSON). The driver is named by the results' stem. Every adversary has an attack of
its own for all that is allowed and every number of queries; the folder gets the cases of each, and the cost table what each took.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from drivegen.adversaries.shared.arena import Arena, Bounds
from drivegen.adversaries.shared.findings import Findings
from drivegen.core import plugins
from drivegen.core.cpu import cpu_seconds
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count, Index
from drivegen.store.costs import write_cost
from drivegen.store.files import write_json
from drivegen.store.lookup import CASES, DRIVEN_CASES
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import shards
from drivegen.world.reactive import Reaction
from stages._door import COST_FOLDER, require, spread
from stages._driven_by import weights_of
from stages._ground import Made


@dataclass(frozen=True)
class Params:
    """Section `attack`.

    Attributes:
        planner: fills in motion. scenarios: so many of each shard. samples: scenes of each, its first samples.
        allowed: of `adversaries.shared.rules.RULES`. queries: runs of the driver in each scenario.
        reaction_steps: others avoid the target's plan for so many steps. reaction: of neighbours, where they react.
        drivers, adversaries: settings of each by its name. methods: those of `adversaries` that attack.
        draws: bootstrap draws behind intervals.
    """

    seed: int
    workers: Count
    planner: str
    scenarios: Count
    samples: Count
    allowed: list[str]
    queries: list[Count]
    reaction_steps: Index
    reaction: Reaction
    drivers: dict[str, dict[str, Any]]
    methods: list[str]
    adversaries: dict[str, dict[str, Any]]
    draws: Count

    def __post_init__(self) -> None:
        if not (self.queries and self.allowed and self.methods):
            raise UnusableInput("params.yaml: attack.queries, attack.allowed, attack.methods: name at least one of each")


def main(
    params: Params, scenarios: Path, models: Path, goals: Path, traffic: Path, cases: Path, results: Path, metrics: Path
) -> None:
    """Attack by every adversary, judge what it found, report."""
    driver, tables, numbers = results.stem, [], {}
    plugins.make("drivers", driver, params.drivers, "attack.drivers")  # what is wrong with it is said before anybody waits
    made_with = [models / "planners" / params.planner, models / "limits.json"]
    read = [scenarios, goals, traffic, *made_with, *weights_of(params.drivers[driver])]
    files = shards(require(scenarios, "run the ingest stage"))
    tasks = [(name, file) for name in params.methods for file in files]
    done = spread(partial(_on_shard, params, driver, (models, goals, traffic)), tasks, params.workers, f"attack {driver}")
    for name, of_shards in groupby(done, key=lambda pair: pair[0][0]):
        about = plugins.about("adversaries", name)
        by_bounds = zip(*[attacks for _, attacks in of_shards], strict=True)
        for bounds, parts in zip(_bounds(params, about), by_bounds, strict=True):
            key, findings = f"{name}.{bounds.allowed}.{bounds.budget}", Findings.joined([found for found, _ in parts])
            costs = {"cases": float(findings.metrics["cases"].sum()), "cpu_seconds": sum(seconds for _, seconds in parts)}
            write_cost(COST_FOLDER, "attack", f"{driver}-{key}", costs)
            run = Run.of("attack", key, asdict(params), read, method=name, driver=driver, backend=bounds.allowed)
            tables.append(result_rows(run, findings.scenarios, findings.metrics))
            write_samples(cases / key / CASES, findings.samples)
            write_samples(cases / key / DRIVEN_CASES, findings.driven)
            head = {"method": name, "title": about["title"], "varies": about["varies"]}
            head |= {key: about.get(key, "") for key in ("proposer", "stand_in")}
            numbers[key] = {**head, **asdict(bounds), **findings.summary(params.draws, params.seed)}
    write_results(results, tables)
    write_json(metrics, numbers)


def _on_shard(
    params: Params, name: str, folders: tuple[Path, Path, Path], task: tuple[str, Path]
) -> list[tuple[Findings, float]]:
    """What an adversary finds against driver `name` on a shard, attack by attack as `_bounds` has them, and the time of each."""
    (models, goals, traffic), (method, shard), attacks = folders, task, []
    about, driver = plugins.about("adversaries", method), plugins.make("drivers", name, params.drivers, "attack.drivers")
    made = Made.open(models, params.planner, goals, traffic)
    on_logs = about["traffic"] == "log"
    ground = made.logs(shard, params.scenarios) if on_logs else made.ground(shard, params.samples, params.scenarios)
    for bounds in _bounds(params, about):
        began, arena = cpu_seconds(), Arena(driver, ground, bounds, params.seed)
        plugins.make("adversaries", method, params.adversaries, "attack.adversaries").attack(arena)
        findings = Findings.of(arena.runs(), driver, method, params.reaction)
        attacks.append((findings, cpu_seconds() - began))
    return attacks


def _bounds(params: Params, about: dict[str, Any]) -> Iterator[Bounds]:
    """Of all attacks of an adversary; one that varies nothing has one run of each of its scenes, of which a log is one."""
    if about["varies"] == "nothing":
        yield Bounds("legal", 1 if about["traffic"] == "log" else params.samples, params.reaction_steps)
        return
    yield from (Bounds(allowed, queries, params.reaction_steps) for allowed in params.allowed for queries in params.queries)
