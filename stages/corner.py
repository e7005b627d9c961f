"""Stage corner@<round>: one round of corner cases for one driver (paper, "DriveGen-CS").

argv: scenarios (folder of shards), models, recorded goals of one selector, round (folder; its name is the number; the
round before lies beside it), metrics (JSON). Round 0 has no knowledge: it is DriveGen's traffic as it is. The round's
folder gets samples and the driven target shard by shard, and knowledge.json, pooled over all rounds so far.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import orjson

from drivegen import plugins
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.pressure import PressureSettings
from drivegen.corner_cases.rounds import Drive, lean_on, learn, play
from drivegen.corner_cases.summary import RoundSummary, summarise
from drivegen.equipment import read_planner
from drivegen.generate import recorded_choices
from drivegen.generators.base import Settings
from drivegen.planners.base import Planner
from drivegen.rollout import Choices
from drivegen.seeds import rng
from drivegen.store.files import write_json
from drivegen.store.goals import read_goals
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import read_shard, shards
from drivegen.verdicts import read_limits
from stages._door import build, enter, require, spread

KNOWLEDGE = "knowledge.json"


@dataclass(frozen=True)
class Params:
    """Section `corner`.

    Attributes:
        driver: plugin under test, with `settings` as its own. simulator: plugin that runs it.
        samples: futures of each scenario. prior_strength: see `Knowledge`. draws: bootstrap draws behind intervals.
        generation, pressure: see their classes.
    """

    seed: int
    workers: int
    driver: str
    driver_settings: dict[str, Any]
    simulator: str
    samples: int
    prior_strength: float
    draws: int
    generation: Settings
    pressure: PressureSettings


@dataclass(frozen=True)
class Task:
    """One shard of one round."""

    shard: Path
    models: Path
    goals: Path
    out: Path
    params: Params
    knowledge: Knowledge


def main(params: Params, scenarios: Path, models: Path, goals: Path, out: Path, metrics: Path) -> dict[str, float]:
    """Play the round, pool what it teaches, report."""
    known = _knowledge_before(out, params)
    tasks = [Task(shard, models, goals, out, params, known) for shard in shards(require(scenarios, "run the ingest stage"))]
    summaries: list[RoundSummary] = []
    learnt = known
    for _, (gained, summary) in spread(_play_shard, tasks, params.workers, f"corner cases, round {out.name}"):
        learnt = learnt + gained
        summaries.append(summary)
    write_json(out / KNOWLEDGE, learnt.to_json())
    numbers = RoundSummary.joined(summaries).numbers(params.draws, rng(params.seed, "corner", "bootstrap"))
    about = {"driver": params.driver, "simulator": params.simulator, "round": int(out.name), "seed": params.seed}
    write_json(metrics, {**about, **numbers, "knowledge": learnt.rows()})
    return {"runs": numbers["runs"]}


def _knowledge_before(out: Path, params: Params) -> Knowledge:
    number = int(out.name)
    if number == 0:
        return Knowledge.none(params.prior_strength)
    path = require(out.parent / str(number - 1) / KNOWLEDGE, f"run the round before: corner@{number - 1}")
    return Knowledge.from_json(orjson.loads(path.read_bytes()))


def _play_shard(task: Task) -> tuple[Knowledge, RoundSummary]:
    params = task.params
    scenarios = read_shard(task.shard)
    recorded = read_goals(require(task.goals / task.shard.name, "run the goals stage"))
    choices = recorded_choices(scenarios, recorded, params.generation.temperature)
    planner, limits = read_planner(task.models, params.generation.planner), read_limits(task.models)
    if int(task.out.name) > 0:
        choices = _leaning(task, choices, planner)
    plugin = plugins.load("drivers", params.driver)
    driver = plugin(build(plugin.settings_type, params.driver_settings, "params.yaml: corner.driver_settings"))
    simulator = plugins.load("simulators", params.simulator)()
    rollout = params.generation.rollout
    drives = play(choices, planner, limits, rollout, driver, simulator, params.samples, params.seed)
    write_samples(task.out / "samples" / task.shard.name, [drive.samples for drive in drives])
    write_samples(task.out / "driven" / task.shard.name, [_driven(drive) for drive in drives])
    gained = learn(Knowledge.none(params.prior_strength), drives, choices, params.pressure.reach)
    return gained, summarise(choices, drives)


def _leaning(task: Task, choices: list[Choices], planner: Planner) -> list[Choices]:
    """Choices under the pressure of what is known, met with the target as it drove in the round before."""
    before = task.out.parent / str(int(task.out.name) - 1) / "driven" / task.shard.name
    expected = [driven.motion[:, 0] for driven in read_samples(require(before, "run the round before"))]
    params = task.params
    return lean_on(choices, expected, planner, task.knowledge, params.pressure, params.seed)


def _driven(drive: Drive) -> Any:
    """The samples with the target's row alone, as it was driven."""
    only = drive.samples
    columns = ("violation", "first_violation", "goal", "natural", "used", "attempts", "dropped")
    return replace(only, motion=drive.target[:, None], **{name: getattr(only, name)[:, :1] for name in columns})


if __name__ == "__main__":
    enter("corner", Params, main)
