"""Cases that were found for one driver, driven by the others: one published table out of the rows of stage `transfer`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from drivegen.report.published.figures import grouped, origin_of, title_of
from drivegen.report.table import Cell, Table, estimate, row

NAME = "transfer"


def transfer_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each method and driver that it searched against, a column for each who drives; `rows` are means over seeds."""
    drivers = list(dict.fromkeys(line["driver"] for line in rows))
    lines = []
    for (method, found_for), of in grouped(rows, ("method", "found_for"), ("driver", "metric")).items():
        cells = (_cell(of[driver, "counted"], of[driver, "untouched"]) for driver in drivers)
        count = str(of[drivers[0], "counted"]["n"])
        lines.append(row(title_of(method), found_for, count, *cells, origin=origin_of(method)))
    return Table(
        NAME,
        "Cases found for one driver, driven by others: share with a counted collision",
        ("", "found for", "cases", *(f"driven by {driver}" for driver in drivers)),
        tuple(lines),
        (
            f"Seeds: {rows[0]['seeds']}, of the first of which the number of cases is; 95 % over recordings; after *without*, "
            "the share in the same scenes without the attack. Others were not searched against: no run of theirs chose a case. "
            "Neighbours are replayed.",
        ),
    )


def _cell(counted: Mapping[str, Any], untouched: Mapping[str, Any]) -> Cell:
    cell = estimate(counted, 2)
    return replace(cell, note="; ".join(filter(None, (cell.note, f"without {untouched['value']:.2f}"))))
