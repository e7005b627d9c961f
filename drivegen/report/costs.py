"""What things cost, as tables out of the warehouse: a query and a title each."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from drivegen.report.table import RESTORED, Table, row
from drivegen.warehouse.database import query

_TRAINING = "cost_of_training"
_NOTE = (
    "Methods' seconds are of whole stages: starting processes, reading scenarios and writing samples are in them (the log's row "
    "is nothing but that), and where goals are chosen, scoring the choice. `drivegen bench` times generation alone: its "
    "figure is smaller."
)
_TABLES = (
    (
        "cost_of_methods",
        "What 1000 scenarios cost",
        {
            "method": "",
            "cpu_seconds_per_1000": "CPU s",
            "of_it_choosing_goals": "of it choosing goals",
            "peak_megabytes": "peak memory [MB]",
            "scenarios": "measured on scenarios",
        },
    ),
    (
        _TRAINING,
        "What training cost",
        {"stage": "", "item": "model", "cpu_seconds": "CPU s", "gpu_seconds": "GPU s"},
    ),
)


def costs_markdown(warehouse: Path, results: Path) -> str:
    """Both tables; models that left results in the folder `results` but were not trained here have rows, too."""
    return "\n".join(_lines(warehouse, results))


def _lines(warehouse: Path, results: Path) -> Iterator[str]:
    yield "Seconds of processors over all processes, of this machine and this run: another run has others."
    yield _NOTE
    for view, title, columns in _TABLES:
        rows = query(warehouse, f"from {view}").to_pylist()
        rows += _elsewhere(rows, results) if view == _TRAINING else ()
        lines = tuple(row(*(_cell(one, name) for name in columns)) for one in rows)
        yield "\n" + Table(view, title, tuple(columns.values()), lines).markdown().rstrip("\n")
    yield ""


def _elsewhere(rows: list[dict[str, Any]], results: Path) -> Iterator[dict[str, Any]]:
    """A row for each model that was trained, by what it left in `results`, but not in this folder."""
    here = {row["stage"] for row in rows}, {(row["stage"], row["item"]) for row in rows}
    for file in sorted(results.glob("train_*.json")):
        if file.stem not in here[0]:
            yield {"stage": file.stem, "item": ""}
    for file in sorted(results.glob("train_*/*.json")):
        if (file.parent.name, file.stem) not in here[1]:
            yield {"stage": file.parent.name, "item": file.stem}


def _cell(row: Mapping[str, Any], name: str) -> str:
    """A value of a row; what is missing was not measured here, but no GPU where other seconds were."""
    value = row.get(name)
    if value is None:
        ran = row.get("cpu_seconds") is not None
        return "none" if name == "gpu_seconds" and ran else RESTORED
    return value if isinstance(value, str) else f"{value:,.0f}"
