"""How natural attacks are: one published table out of the rows of stage `naturalness`."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivegen.report.published.figures import grouped, origin_of, title_of
from drivegen.report.table import Table, estimate, row

NAME = "naturalness"


def naturalness_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each attack and driver; `rows` are means over seeds."""
    lines = []
    for (method, allowed, driver), of in grouped(rows, ("method", "allowed", "found_for"), ("metric",)).items():
        cells = (estimate(of[metric], 2) for metric in ("attack", "before", "less"))
        count = str(of["attack"]["n"])
        lines.append(row(title_of(method), allowed, driver, count, *cells, origin=origin_of(method)))
    return Table(
        NAME,
        "How natural is what attackers do: log likelihood under SMART, a generator that made none of it [nat per half second]",
        ("", "allowed", "found for", "cases", "as attacked", "before", "less"),
        tuple(lines),
        (
            f"Seeds: {rows[0]['seeds']}, of the first of which the number of cases is; 95 % over recordings. Of vehicles that "
            "were exchanged, in cases that count; those in which nobody was are left out. Motion is told in SMART's tokens; how "
            "far it is from the nearest one does not count, so that what no token resembles looks more natural than it is.",
        ),
    )
