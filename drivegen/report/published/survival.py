"""Which cases hold when neighbours react: one published table out of the rows of stage `survival`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from drivegen.corner_cases.survival import ATTENTION, Reacting
from drivegen.report.published.figures import grouped, origin_of, title_of
from drivegen.report.table import Cell, Table, estimate, row

ORDINARY = "ordinary"
"""The attention whose figure stands before those of the others."""

WHO = tuple(str(who) for who in Reacting if who != Reacting.NOBODY)


def survival_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each driver and adversary, a column for each who reacts; `rows` are means over seeds."""
    lines = []
    for (driver, method), of in grouped(rows, ("driver", "method"), ("reacting", "attention")).items():
        cells = (_cell({name: of[who, name] for name in ATTENTION}) for who in WHO)
        count = str(of[WHO[0], ORDINARY]["n"])
        lines.append(row(driver, title_of(method), count, *cells, origin=origin_of(method)))
    others = ", ".join(f"{name} {at[0]:g} s, {at[1]:g} m/s2" for name, at in ATTENTION.items() if at is not None)
    return Table(
        "survival",
        "Which cases hold when others react: share that still ends in a counted collision",
        ("driver", "", "cases", *(f"reacting: {who}" for who in WHO)),
        tuple(lines),
        (
            f"Legal cases; seeds: {rows[0]['seeds']}, of the first of which the number of cases is; 95 % over recordings. "
            f"Who reacts follows its own way and brakes after a delay, at most so hard: {others}, ordinary ones "
            "as `drive.reaction` says; these stand first. "
            "Where nobody was exchanged, the one that was hit counts as the attacker.",
        ),
    )


def _cell(by_attention: Mapping[str, Mapping[str, Any]]) -> Cell:
    cell = estimate(by_attention[ORDINARY], 2)
    others = (f"{name} {line['value']:.2f}" for name, line in by_attention.items() if name != ORDINARY)
    return replace(cell, note="; ".join(filter(None, (cell.note, *others))))
