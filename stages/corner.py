"""Stage corner@<round>: one round of corner cases for one driver (paper, "DriveGen-CS").

argv: scenarios (folder of shards), models, recorded goals of one selector, round (folder; its name is the number; the
round before lies beside it), results (Parquet rows), metrics (JSON). Round 0 has no knowledge: it is DriveGen's traffic as it
is. The round's folder gets samples and the driven target shard by shard, knowledge.json, pooled over all rounds so far, and a few
collisions in pictures and words. Where a language model chooses goals (`goals: vlm`), it is shown what the round before left,
and its calls are rows of .drivegen/calls/corner-<round>*.parquet.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.seeds import rng
from drivegen.core.settings import Count, Index, Positive
from drivegen.corner_cases.asking import asking, forecast
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.one_round import Round, RoundSettings
from drivegen.corner_cases.round_folder import RoundFolder
from drivegen.corner_cases.rounds import METHOD
from drivegen.corner_cases.summary import RoundSummary
from drivegen.drivers.base import Driver
from drivegen.lm.model import LanguageModel
from drivegen.lm.settings import RecordSettings, RoleSettings
from drivegen.questions.account import Account
from drivegen.questions.asking import Asking
from drivegen.questions.asking import Settings as AskingSettings
from drivegen.questions.goals import examples
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.scenarios import count, shards
from stages._door import build, read_params, require, spread
from stages._driven_by import weights_of

GOALS = ("reweighting", "vlm")


@dataclass(frozen=True)
class Params(RoundSettings):
    """Section `corner`: `RoundSettings`, and what goes on around the play.

    Attributes:
        driver: plugin under test, with `driver_settings` as its own. simulator: plugin that runs it.
        drives_by: the driver's file or its weights, on which the stage depends.
        prior_strength: see `Knowledge`. draws: bootstrap draws behind intervals.
        goals: who leans on the goals of social vehicles: "reweighting", by what is known, or "vlm", a language model that
            is told what is known; where it gives no answer the re-weighting counts. vlm: how it is asked.
        pictures: collisions that a round leaves in pictures, at most.
    """

    workers: Count
    driver: str
    driver_settings: dict[str, Any]
    drives_by: str
    simulator: str
    prior_strength: Positive
    draws: Count
    goals: str
    vlm: AskingSettings
    pictures: Index

    def __post_init__(self) -> None:
        if self.goals not in GOALS:
            raise UnusableInput(f"corner: goals is one of {', '.join(GOALS)}, not {self.goals!r}")
        if any(folder != Path(self.drives_by) for folder in weights_of(self.driver_settings)):
            raise UnusableInput(
                "params.yaml: corner.drives_by must be corner.driver_settings.weights: rounds are made anew with what it names"
            )


def main(params: Params, scenarios: Path, models: Path, goals: Path, out: Path, results: Path, metrics: Path) -> dict[str, float]:
    """Play the round, pool what it teaches, report."""
    folder = RoundFolder(out)
    knowledge = folder.knowledge_before(params.prior_strength)
    asker = _asker(folder, params, knowledge)
    files = shards(require(scenarios, "run the ingest stage"))
    simulator = plugins.load("simulators", params.simulator)()
    this = Round(folder, models, goals, _driver(params), simulator, params, knowledge, asker, Account())
    if asker is None:
        played = list(spread(this.play, files, params.workers, f"corner cases, round {out.name}"))
    else:  # in one process: one budget, one list of calls
        print(forecast(asker, this.choices(files[0]), sum(map(count, files))), flush=True)
        with asker.model.ledger.kept(f"corner-{out.name}"):
            played = list(spread(this.play, files, 1, f"corner cases, round {out.name}"))
    pooled = sum((shard.knowledge for _, shard in played), knowledge)
    folder.write_knowledge(pooled)
    folder.write_pictures([(file, hit) for file, shard in played for hit in shard.collisions], pooled, params.pictures)
    summary = RoundSummary.joined([shard.summary for _, shard in played])
    before = [folder.before.path] if folder.number else []
    made_with = [models / "planners" / params.generation.planner, models / "limits.json"]
    read = [scenarios, goals, *made_with, *before, *weights_of(params.driver_settings)]
    run = Run.of("corner", out.name, asdict(params), read, method=METHOD, driver=params.driver, backend=params.simulator)
    ids, sample, each = summary.per_run()
    write_results(results, [result_rows(run, summary.scenarios, summary.metrics), result_rows(run, ids, each, sample)])
    numbers = summary.numbers(params.draws, rng(params.seed, "corner", "bootstrap"))
    about = {"driver": params.driver, "simulator": params.simulator, "round": folder.number, "seed": params.seed}
    write_json(metrics, {**about, **this.goals_by(), **numbers, "knowledge": pooled.rows()})
    return {"runs": numbers["runs"]}


def _driver(params: Params) -> Driver:
    plugin = plugins.load("drivers", params.driver)
    driver: Driver = plugin(build(plugin.settings_type, params.driver_settings, "params.yaml: corner.driver_settings"))
    return driver


def _asker(folder: RoundFolder, params: Params, knowledge: Knowledge) -> Asking | None:
    """Who is asked about goals: nobody in round 0, which has nothing to tell."""
    if params.goals != "vlm" or folder.number == 0:
        return None
    role, records = read_params("lm.corner_cases", RoleSettings), read_params("lm.records", RecordSettings)
    shown = folder.before.shown() + examples(params.vlm.examples)
    model = LanguageModel("corner_cases", role, records.open())
    return asking(model, params.vlm, params.seed, knowledge, shown, params.pressure.reaction_time)
