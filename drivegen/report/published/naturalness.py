"""How natural attacks are: one published table out of the rows of stage `naturalness`."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivegen.core import plugins
from drivegen.report.sections.attack import OURS
from drivegen.report.table import Table, estimate, row

NAME = "naturalness"


def naturalness_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each attack and driver; `rows` are means over seeds."""
    of = {(line["method"], line["allowed"], line["found_for"], line["metric"]): line for line in rows}
    lines = []
    for key in dict.fromkeys(key[:3] for key in of):
        method, allowed, driver = key
        title = plugins.about("adversaries", method)["title"]
        cells = [estimate(of[*key, metric], 2) for metric in ("attack", "before", "less")]
        origin = "ours" if method == OURS else "rival"
        lines.append(row(title, allowed, driver, str(of[*key, "attack"]["n"]), *cells, origin=origin))
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
