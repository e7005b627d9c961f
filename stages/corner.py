"""Stage corner@<round>: one round of corner cases for one driver (paper, "DriveGen-CS").

argv: scenarios (folder of shards), models, recorded goals of one selector, round (folder; its name is the number; the
round before lies beside it), metrics (JSON). Round 0 has no knowledge: it is DriveGen's traffic as it is. The round's
folder gets samples and the driven target shard by shard, knowledge.json, pooled over all rounds so far, and a few
collisions in pictures and words. Where a language model chooses goals (`goals: vlm`), it is shown what the round before left,
and its calls are rows of .drivegen/calls/corner-<round>.parquet.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson
import pyarrow.parquet as pq

from drivegen import plugins
from drivegen.corner_cases.asking import asking, endanger, scene_of
from drivegen.corner_cases.collisions import Collision, collisions, telling, write_picture
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.pressure import PressureSettings
from drivegen.corner_cases.rounds import lean_on, learn, play
from drivegen.corner_cases.summary import RoundSummary, summarise
from drivegen.equipment import read_planner
from drivegen.errors import UnusableInput
from drivegen.generate import recorded_choices
from drivegen.generators.base import Settings
from drivegen.lm.ledger import FOLDER as CALLS
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import RANKING_TOKENS
from drivegen.lm.settings import RecordSettings, RoleSettings
from drivegen.planners.base import Planner
from drivegen.rollout import Choices
from drivegen.seeds import rng
from drivegen.selectors._vlm_account import Account
from drivegen.selectors._vlm_asking import Asking
from drivegen.selectors._vlm_asking import Settings as AskingSettings
from drivegen.selectors._vlm_question import examples
from drivegen.settings import Count, Index, Positive
from drivegen.store.files import write_json
from drivegen.store.goals import read_goals
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import read_shard, shards
from drivegen.verdicts import read_limits
from stages._door import build, enter, read_params, require, spread

KNOWLEDGE, COLLISIONS = "knowledge.json", "collisions"
"""Of a round's folder, beside samples and driven targets: the counts, and pictures (PNG) of collisions with words (TXT)."""

GOALS = ("reweighting", "vlm")

_SCENES = 3  # whose questions are really made for the forecast of what calls will cost


@dataclass(frozen=True)
class Params:
    """Section `corner`.

    Attributes:
        driver: plugin under test, with `settings` as its own. simulator: plugin that runs it.
        samples: futures of each scenario. prior_strength: see `Knowledge`. draws: bootstrap draws behind intervals.
        generation, pressure: see their classes.
        goals: who leans on the goals of social vehicles: "reweighting", by what is known, or "vlm", a language model that
            is told what is known; where it gives no answer the re-weighting counts. vlm: how it is asked.
        pictures: collisions that a round leaves in pictures, at most.
    """

    seed: int
    workers: Count
    driver: str
    driver_settings: dict[str, Any]
    simulator: str
    samples: Count
    prior_strength: Positive
    draws: Count
    generation: Settings
    pressure: PressureSettings
    goals: str
    vlm: AskingSettings
    pictures: Index

    def __post_init__(self) -> None:
        if self.goals not in GOALS:
            raise UnusableInput(f"corner: goals is one of {', '.join(GOALS)}, not {self.goals!r}")


@dataclass(frozen=True)
class Task:
    """One shard of one round; `asked` is who is asked about goals, None where nobody is."""

    shard: Path
    models: Path
    goals: Path
    out: Path
    params: Params
    knowledge: Knowledge
    asked: Asking | None
    account: Account


def main(params: Params, scenarios: Path, models: Path, goals: Path, out: Path, metrics: Path) -> dict[str, float]:
    """Play the round, pool what it teaches, report."""
    known = _knowledge_before(out, params)
    asked, account = _asking(out, params, known), Account()
    found = shards(require(scenarios, "run the ingest stage"))
    tasks = [Task(shard, models, goals, out, params, known, asked, account) for shard in found]
    if asked is None:
        played = list(spread(_play_shard, tasks, params.workers, f"corner cases, round {out.name}"))
    else:  # in one process: one budget, one list of calls
        print(_forecast(asked, tasks), flush=True)
        with asked.model.ledger.kept(CALLS / f"corner-{out.name}.parquet"):
            played = list(spread(_play_shard, tasks, 1, f"corner cases, round {out.name}"))
    learnt = sum((gained for _, (gained, _, _) in played), known)
    write_json(out / KNOWLEDGE, learnt.to_json())
    _show([(task, one) for task, (_, _, hits) in played for one in hits], learnt, params.pictures)
    summary = RoundSummary.joined([one for _, (_, one, _) in played])
    numbers = summary.numbers(params.draws, rng(params.seed, "corner", "bootstrap"))
    about = {"driver": params.driver, "simulator": params.simulator, "round": int(out.name), "seed": params.seed}
    told = {"goals": asked.model.description, "asking": account.table()} if asked else {"goals": "statistical re-weighting"}
    write_json(metrics, {**about, **told, **numbers, "knowledge": learnt.rows()})
    return {"runs": numbers["runs"]}


def _asking(out: Path, params: Params, known: Knowledge) -> Asking | None:
    """Who is asked about goals: nobody in round 0, which has nothing to tell."""
    if params.goals != "vlm" or int(out.name) == 0:
        return None
    role, records = read_params("lm.corner_cases", RoleSettings), read_params("lm.records", RecordSettings)
    shown = examples(str(_before(out) / COLLISIONS)) + examples(params.vlm.examples)
    model, early = LanguageModel("corner_cases", role, records.open()), params.pressure.reaction_time
    return asking(model, params.vlm, params.seed, known, shown, early)


def _forecast(asked: Asking, tasks: list[Task]) -> str:
    """What the round's calls will cost, from the questions about its first scenes."""
    choices = _choices(tasks[0])[:_SCENES]
    prompts = [prompt for choice in choices for prompt in asked.questions(scene_of(choice, choice))]
    answered = RANKING_TOKENS * sum(len(c.candidates) - 1 for c in choices) // max(len(prompts), 1)
    total = sum(pq.read_metadata(task.shard).num_rows for task in tasks)  # a row is a scenario
    return asked.model.forecast(prompts, answered, total / len(choices))


def _show(hits: list[tuple[Task, Collision]], knowledge: Knowledge, most: int) -> None:
    """Pictures and words of the most telling collisions."""
    where = {one.scenario_id: task for task, one in hits}
    for number, one in enumerate(telling([one for _, one in hits], knowledge, most)):
        task = where[one.scenario_id]
        [scenario] = [s for s in read_shard(task.shard) if s.scenario_id == one.scenario_id]
        traffic, driven = (
            next(s for s in read_samples(task.out / part / task.shard.name) if s.scenario_id == one.scenario_id)
            for part in ("samples", "driven")
        )
        write_picture(task.out / COLLISIONS / str(number), one, scenario, traffic, driven.motion[:, 0], knowledge)


def _knowledge_before(out: Path, params: Params) -> Knowledge:
    if int(out.name) == 0:
        return Knowledge.none(params.prior_strength)
    path = require(_before(out) / KNOWLEDGE, f"run the round before: corner@{_before(out).name}")
    return Knowledge.from_json(orjson.loads(path.read_bytes()))


def _before(out: Path) -> Path:
    """The folder of the round before."""
    return out.parent / str(int(out.name) - 1)


def _choices(task: Task) -> list[Choices]:
    recorded = read_goals(require(task.goals / task.shard.name, "run the goals stage"))
    return recorded_choices(read_shard(task.shard), recorded, task.params.generation.temperature)


def _play_shard(task: Task) -> tuple[Knowledge, RoundSummary, list[Collision]]:
    params, choices = task.params, _choices(task)
    planner, limits = read_planner(task.models, params.generation.planner), read_limits(task.models)
    if int(task.out.name) > 0:
        choices = _leaning(task, choices, planner)
    plugin = plugins.load("drivers", params.driver)
    driver = plugin(build(plugin.settings_type, params.driver_settings, "params.yaml: corner.driver_settings"))
    simulator = plugins.load("simulators", params.simulator)()
    rollout = params.generation.rollout
    drives = play(choices, planner, limits, rollout, driver, simulator, params.samples, params.seed)
    write_samples(task.out / "samples" / task.shard.name, [drive.samples for drive in drives])
    write_samples(task.out / "driven" / task.shard.name, [drive.driven for drive in drives])
    gained = learn(Knowledge.none(params.prior_strength), drives, choices, params.pressure.reach)
    hits = [one for pair in zip(choices, drives, strict=True) for one in collisions(*pair)]
    return gained, summarise(choices, drives), hits


def _leaning(task: Task, choices: list[Choices], planner: Planner) -> list[Choices]:
    """Choices under the pressure of what is known, met with the target as it drove in the round before."""
    before = _before(task.out) / "driven" / task.shard.name
    expected = [driven.motion[:, 0] for driven in read_samples(require(before, "run the round before"))]
    params = task.params
    leaning = lean_on(choices, expected, planner, task.knowledge, params.pressure, params.seed)
    return leaning if task.asked is None else endanger(choices, leaning, task.asked, params.pressure.max_ratio, task.account)


if __name__ == "__main__":
    enter("corner", Params, main)
