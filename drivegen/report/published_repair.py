"""Repaired drivers, published: a table for each driver and who tested it, out of the rows of stage `repair`."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drivegen.core import plugins
from drivegen.report.table import NOT_MEASURED, Cell, Row, Table, row

VERSIONS = {
    "before": "taught on logs",
    "longer": "tuned on logs",
    "repaired": "tuned for as long, its cases among the logs",
}
LESS = ".minus_longer"

SHARES = {
    "counted": "counted collisions",
    "avoidable": "avoidable ones",
    "collision": "all collisions",
    "distance": "Dis [m]",
    "comfort_absolute": "Comfort",
}
"""Metrics -> columns before the kinds."""

Rows = Sequence[Mapping[str, Any]]


def repair_tables(driver: str, rows: Rows) -> Iterator[Table]:
    """A table for each tester of the driver; `rows` are means over seeds."""
    for tester in dict.fromkeys(line["tester"] for line in rows):
        mine = {(line["version"], line["metric"]): line for line in rows if line["tester"] == tester}
        kinds = [metric for _, metric in mine if metric.startswith("kind.") and not metric.endswith(LESS)]
        met = [kind for kind in dict.fromkeys(kinds) if any(mine[version, kind]["value"] for version in VERSIONS)]
        columns = [metric for metric in (*SHARES, *met) if ("before", metric) in mine]
        lines = [_line(title, [mine.get((version, metric)) for metric in columns]) for version, title in VERSIONS.items()]
        lines.append(_line("the last less the one before", [mine.get(("repaired", f"{metric}{LESS}")) for metric in columns]))
        title = plugins.about("adversaries", tester)["title"]
        first = mine["before", "counted"]
        yield Table(
            f"repair-{driver}-{tester}",
            f"Repair: {driver}, tested by {title}",
            ("", *(SHARES.get(metric, metric.removeprefix("kind.")) for metric in columns)),
            tuple(lines),
            (
                f"{first['n']} scenes, {first['seeds']} seeds, 95 % over recordings, the last row paired by scene. Kinds are "
                "shares of scenes with a counted collision of that kind.",
                "Cases come from one half of the recordings, the test is in the other, both ways; both halves are of the same "
                "networks. Who was tuned on logs alone learnt for as long.",
            ),
        )


def _line(title: str, figures: Sequence[Mapping[str, Any] | None]) -> Row:
    return row(title, *map(_cell, figures), origin="ours")


def _cell(line: Mapping[str, Any] | None) -> Cell:
    if line is None or line["value"] is None:
        return Cell("-" if line is None else NOT_MEASURED)
    ends = "" if line["low"] is None else f"{line['low']:.3f} to {line['high']:.3f}"
    return Cell(f"{line['value']:.3f}", ends)
