"""How much of what is there adversaries find, and what parts of DriveGen-CS are worth: tables of rows of the stage `recall`."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivegen.adversaries.shared.recall import EVERY, VARIED
from drivegen.report.published.figures import grouped, origin_of, title_of
from drivegen.report.table import Table, estimate, row

METRICS = ("counted", "avoidable", "recall")
VARIANTS = {
    "": "whole",
    "no_variations": "goals as they are, without variations",
    "no_shifts": "variations without those shifted across",
    "no_warning": "without regard to warning",
    "anyone_behind": "without regard to who comes from behind",
    "no_ease": "without regard to how hard vehicles accelerate",
    "no_turns": "without turns among attackers",
    "knowledge": "with knowledge of encounters",
}
"""Variants of DriveGen-CS in words; one that is not here stands by its name."""


def recall_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each driver, adversary and number of runs, behind what there is; `rows` are means over seeds."""
    lines = []
    for (driver, method, queries), of in grouped(rows, ("driver", "method", "queries"), ("metric",)).items():
        if _variant(method):
            continue
        title, origin = ("every goal driven", "") if method == EVERY else (title_of(method), origin_of(method))
        cells = (estimate(of.get(metric)) for metric in METRICS)
        lines.append(row(driver, title, "all" if queries is None else str(queries), *cells, origin=origin))
    every = next(line for line in rows if line["method"] == EVERY)
    return Table(
        "recall",
        "How much adversaries find of what is there: scenes in which one exchanged goal makes a driver fail",
        ("driver", "", "runs", "counted", "avoidable", "of what is there"),
        tuple(lines),
        (
            f"Scenes: {every['n']}, seeds: {every['seeds']}, 95 % over recordings. There is what fails as it is, or once one "
            "legal goal of one vehicle is exchanged, by any of several motions towards it; all are driven. Counted and avoidable "
            "are shares of all scenes, by the first failure found. Whoever draws one motion towards each goal cannot find all; "
            "who varies goals (DriveGen-CS, CAT) also finds what is not among them, which counts in the first two columns.",
        ),
    )


def ablation_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each driver and variant of DriveGen-CS, a column for each number of runs."""
    counted = [line for line in rows if line["metric"] == "counted"]
    queries = sorted({line["queries"] for line in counted} - {None})
    own = grouped((line for line in counted if line["method"].partition(".")[0] == VARIED), ("driver", "method"), ("queries",))
    return Table(
        "ablation",
        "What each part of DriveGen-CS is worth: scenes with a counted collision, by runs of the driver",
        ("driver", "DriveGen-CS", *map(str, queries)),
        tuple(row(*_names(*key), *(estimate(of.get(q)) for q in queries), origin="ours") for key, of in own.items()),
        (
            "Shares of the scenes of the table of what is there to be found. The first run shows how a driver drives when nobody "
            "is exchanged, the second is the candidate that ranks best: what comes later is rehearsal.",
        ),
    )


def _names(driver: str, method: str) -> tuple[str, str]:
    return driver, VARIANTS.get(_variant(method), _variant(method).replace("_", " "))


def _variant(method: str) -> str:
    return method.partition(".")[2]
