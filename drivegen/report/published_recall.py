"""How much of what is there adversaries find: one published table out of the rows of stage `recall`."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivegen.core import plugins
from drivegen.report.table import Table, estimate, row

NAME = "recall"
EVERY = "every_goal"
METRICS = ("counted", "avoidable", "recall")


def recall_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each driver, adversary and number of runs, behind what there is; `rows` are means over seeds."""
    of = {(line["driver"], line["method"], line["queries"], line["metric"]): line for line in rows}
    lines = []
    for key in dict.fromkeys(key[:3] for key in of):
        driver, method, queries = key
        title = "every goal driven" if method == EVERY else plugins.about("adversaries", method)["title"]
        origin = "" if method == EVERY else "ours" if method == "drivegen_cs" else "rival"
        cells = (estimate(of.get((*key, metric)), 3) for metric in METRICS)
        lines.append(row(driver, title, "all" if queries is None else str(queries), *cells, origin=origin))
    every = next(line for line in rows if line["method"] == EVERY)
    return Table(
        NAME,
        "How much adversaries find of what is there: scenes in which one exchanged goal makes a driver fail",
        ("driver", "", "runs", "counted", "avoidable", "of what is there"),
        tuple(lines),
        (
            f"Scenes: {every['n']}, seeds: {every['seeds']}, 95 % over recordings. There is what fails as it is, or once one "
            "legal goal of one vehicle is exchanged, by any of several motions towards it; all are driven. Counted and avoidable "
            "are shares of all scenes, by the first failure found. Whoever draws one motion towards each goal cannot find all.",
        ),
    )
