"""Repaired drivers, published: a table for each driver and who tested it, out of the rows of stage `repair`."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drivegen.report.published.figures import grouped, title_of
from drivegen.report.table import Table, estimate, row

VERSIONS = {
    "before": "taught on logs",
    "longer": "tuned on logs",
    "repaired": "tuned for as long, its cases among the logs",
}
LESS, TAUGHT = ".minus_longer", "cases_taught"

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
    for tester, mine in grouped(rows, ("tester",), ("version", "metric")).items():
        kinds = [metric for _, metric in mine if metric.startswith("kind.") and not metric.endswith(LESS)]
        met = [kind for kind in dict.fromkeys(kinds) if any(mine[version, kind]["value"] for version in VERSIONS)]
        columns = [metric for metric in (*SHARES, *met) if ("before", metric) in mine]
        names = {title: [(version, metric) for metric in columns] for version, title in VERSIONS.items()}
        names["the last less the one before"] = [("repaired", f"{metric}{LESS}") for metric in columns]
        taught = [line["value"] for version, line in mine.items() if version == ("repaired", TAUGHT)]
        first = mine["before", "counted"]
        yield Table(
            f"repair-{driver}-{tester}",
            f"Repair: {driver}, tested by {title_of(tester)}",
            ("", *(SHARES.get(metric, metric.removeprefix("kind.")) for metric in columns)),
            tuple(row(title, *(estimate(mine.get(name)) for name in of), origin="ours") for title, of in names.items()),
            (
                f"Scenes: {first['n']}, seeds: {first['seeds']}, 95 % over recordings, the last row paired by scene. Kinds are "
                "shares of scenes with a counted collision of that kind.",
                "Cases come from one half of the recordings, the test is in the other, both ways; both halves are of the same "
                "networks. Who was tuned on logs alone learnt for as long.",
                *(f"{number:g} cases taught: those that the careful driver who teaches gets through." for number in taught),
            ),
        )
