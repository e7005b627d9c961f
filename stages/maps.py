"""Stage `maps`: roads from words, each as a SUMO network, an account and a picture.

argv: out (gets <name>/{map.net.xml, map.json, map.png}), results (Parquet rows, where a map stands for a scenario), table (JSON,
one row per description). Where a language model writes them, what it will cost is told before the first call, first questions go
in one batch if lm.maps.batch says so, and its calls are rows of .drivegen/calls/maps*.parquet.
"""

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import MAP_TOKENS
from drivegen.lm.settings import RecordSettings, RoleSettings
from drivegen.maps.build import build_map
from drivegen.maps.writers.base import ROUNDS
from drivegen.store.files import write_json
from drivegen.store.results import Run, record_rows, write_results
from drivegen.words.writer import asking_writer, writer_called
from stages._door import read_params, spread

_ASKING = "language_model"
"""Writers whose names begin so ask one."""


@dataclass(frozen=True)
class Params:
    """Section `maps`: the writer's name, and descriptions by the name of the map's folder."""

    seed: int
    workers: Count
    writer: str
    prompts: dict[str, str]


@dataclass(frozen=True)
class _Task:
    name: str
    text: str
    seed: int
    writer: str
    folder: Path
    model: LanguageModel | None


def main(params: Params, out: Path, results: Path, table: Path) -> None:
    """Build every map; a description that is not understood is a row in the table, not the end of the stage."""
    model = _language_model() if params.writer.startswith(_ASKING) else None
    tasks = [_Task(name, text, params.seed, params.writer, out / name, model) for name, text in sorted(params.prompts.items())]
    if model is None:
        rows = [row for _, row in spread(_build, tasks, params.workers, "maps")]
    else:  # in one process: one budget, one list of calls
        questions = asking_writer(params.writer, model).first_questions(task.text for task in tasks)
        print(model.forecast(questions, MAP_TOKENS, repairs=ROUNDS), flush=True)
        with model.ledger.kept("maps"):
            model.ask_ahead(questions, sample=params.seed)
            rows = [row for _, row in spread(_build, tasks, 1, "maps")]
    good = Counter[str]()
    for row in rows:
        good.update(name for name in ("understood", "network", "as_asked") if row[name])
    counts = {name: good[name] for name in ("understood", "network", "as_asked")}
    write_json(table, {"descriptions": len(rows), **counts, "maps": rows})
    run = Run.of("maps", table.stem, asdict(params), [], backend=params.writer)
    write_results(results, [record_rows(run, {row["name"]: row for row in rows})])
    if good["network"] == 0:
        raise UnusableInput("none of the descriptions in params.yaml (maps.prompts) became a map")
    print(f"maps: {good['as_asked']} of {len(rows)} descriptions became the road that was asked for")


def _language_model() -> LanguageModel:
    return LanguageModel("maps", read_params("lm.maps", RoleSettings), read_params("lm.records", RecordSettings).open())


def _build(task: _Task) -> dict[str, Any]:
    """One map; the row says who wrote it and how far it got."""
    row: dict[str, Any] = {"name": task.name, "text": task.text, "understood": False, "network": False, "as_asked": False}
    try:
        built = build_map(task.text, task.seed, writer_called(task.writer, task.model), task.folder)
    except UnusableInput as error:
        # What netconvert refuses was understood; what the writer refuses was not.
        return {
            **row,
            "writer": task.writer,
            "reason": error.reason,
            "why": str(error),
            "understood": error.reason.startswith("netconvert"),
        }
    road = built.structure
    numbers = {"writer": built.account["backend"], "kind": built.account["kind"], "reason": ""}
    numbers |= {"ignored": built.account["ignored"], "failed": built.account["failed"]}
    numbers |= {"lanes": len(built.road_map), "junctions": road.junctions, "roundabouts": len(road.roundabouts)}
    numbers |= {"most_lanes": road.max_lanes, "length": road.length, "turn": road.turn, "signals": road.signals}
    return {**row, **numbers, "understood": True, "network": True, "as_asked": built.as_asked}
