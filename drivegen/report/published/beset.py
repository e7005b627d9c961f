"""What attackers find where the target is beset: one published table out of the rows of stage `beset`."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivegen.report.published.figures import grouped, origin_of, title_of
from drivegen.report.table import Table, estimate, row

NAME = "beset"
COLUMNS = {"counted": "counted", "avoidable": "avoidable", "survives_reaction": "holds when all react", "kinds": "kinds"}


def beset_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each driver, adversary and way of placing; `rows` are means over seeds."""
    lines = []
    for (driver, method, placed), of in sorted(grouped(rows, ("driver", "method", "placed"), ("metric",)).items()):
        cells = (estimate(of.get(metric), 0 if metric == "kinds" else 3) for metric in COLUMNS)
        lines.append(row(driver, title_of(method), placed, *cells, origin=origin_of(method)))
    counts = {line["placed"]: line["n"] for line in rows}
    return Table(
        NAME,
        "What attackers find on new maps, vehicles placed as always or so that they beset the target",
        ("driver", "", "placed", *COLUMNS.values()),
        tuple(lines),
        (
            f"Scenes: {_counted(counts)}; seeds: {rows[0]['seeds']}; 95 % over maps. Besetting vehicles take the lanes beside, "
            "before, behind and across the target's way first. Shares are of all scenes, of cases where it says *holds*. "
            "Nobody's traffic looks like that: no rate follows from it.",
        ),
    )


def _counted(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} placed {placed}" for placed, count in counts.items())
