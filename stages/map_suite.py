"""Stage `map_suite`: how often a map from words is the map that was asked for, for every writer.

argv: the table (JSON). A writer that needs a language model where none is configured (lm.maps) stands in it as not measured.
Where one is, what it will cost is told before the first call, first questions go in one batch if lm.maps.batch says so, and its
calls are rows of .drivegen/calls/map_suite-<writer>*.parquet. Processor times go to the cost table.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen.core.settings import Count
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import MAP_TOKENS
from drivegen.lm.settings import RecordSettings, RoleSettings
from drivegen.maps.suite.cases import Case, outside_cases, own_cases
from drivegen.maps.suite.table import not_measured, published
from drivegen.maps.suite.trials import tried
from drivegen.maps.writers.base import ROUNDS, MapWriter
from drivegen.store.files import write_json
from drivegen.words.judge import traffic_lacking
from drivegen.words.writer import asking_writer, writer_called
from stages._door import read_params


@dataclass(frozen=True)
class Params:
    """Section `map_suite`.

    Attributes:
        writers: "offline", the phrase table. models: files of drivegen/maps/writers, which ask the language model of lm.maps.
        every: only every n-th description is tried, 1 for all.
        outside: a folder with map_prompts.jsonl and check_map.py whose descriptions are tried too, "" for none.
    """

    seed: int
    writers: list[str]
    models: list[str]
    every: Count
    outside: str


def main(params: Params, table: Path) -> dict[str, float]:
    """Try every writer; returns what each took, for the cost table."""
    cases = [*own_cases(), *(outside_cases(Path(params.outside)) if params.outside else [])][:: params.every]
    costs = {"descriptions": float(len(cases))}
    results = {name: _measured(name, writer_called(name), cases, params.seed, costs) for name in params.writers}
    role = read_params("lm.maps", RoleSettings)
    for name in params.models:
        if not role.model:
            results[name] = not_measured(name.replace("_", " "))
            continue
        model = LanguageModel("maps", role, read_params("lm.records", RecordSettings).open())
        writer = asking_writer(name, model)
        questions = writer.first_questions(case.text for case in cases)
        print(f"map_suite, {name}: {model.forecast(questions, MAP_TOKENS, repairs=ROUNDS)}", flush=True)
        with model.ledger.kept(f"map_suite-{name}"):
            model.ask_ahead(questions, sample=params.seed)
            results[name] = _measured(name, writer, cases, params.seed, costs)
    write_json(table, {"descriptions": len(cases), "writers": results})
    return costs


def _measured(name: str, writer: MapWriter, cases: list[Case], seed: int, costs: dict[str, float]) -> dict[str, Any]:
    trials = tried(cases, writer, seed, traffic_lacking)
    costs[f"cpu_seconds of {name}"] = sum(trial.seconds for trial in trials)
    print(f"map_suite: {writer.description}: {sum(trial.right for trial in trials)} of {len(trials)} right", flush=True)
    return published(writer.description, trials)
