"""By how much DriveGen-CS leads each other adversary, scene by scene: one published table for each driver."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.seeds import rng
from drivegen.report.published.figures import as_columns, grouped, title_of
from drivegen.report.sections.attack import OURS
from drivegen.report.table import Table, estimate, row

METRICS = ("counted", "avoidable")

Values = Mapping[str, Mapping[str, float]]
"""A metric of one attack: its value in each scenario, by metric and scenario."""


def lead_rows(driver: str, attacks: Mapping[str, Values], draws: int, seed: int) -> Iterator[dict[str, Any]]:
    """Rows {driver, method, allowed, queries, metric, value, low, high, n} for attacks by `<method>.<allowed>.<queries>`.

    Values are shares of DriveGen-CS less the other's in the same n scenes, with 95 % over recordings. Who is allowed something
    else or has other numbers of runs is compared with nobody.
    """
    for key, other in attacks.items():
        method, allowed, queries = key.split(".")
        ours = attacks.get(f"{OURS}.{allowed}.{queries}")
        if ours is None or method == OURS:
            continue
        scenes = sorted(other[METRICS[0]].keys() & ours[METRICS[0]].keys())
        less = np.array([[ours[metric][scene] - other[metric][scene] for metric in METRICS] for scene in scenes])
        random = rng(seed, "lead", driver, key)
        intervals = bootstrap_means(less, [recording(scene) for scene in scenes], draws, random)
        about = {"driver": driver, "method": method, "allowed": allowed, "queries": int(queries)}
        for metric, interval in zip(METRICS, intervals, strict=True):
            yield {**about, "metric": metric, **as_columns(interval), "n": len(scenes)}


def lead_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A line for each driver, adversary and rule."""
    groups = grouped(rows, ("driver", "method", "allowed", "queries"), ("metric",))
    lines = [
        row(driver, title_of(method), allowed, str(queries), *(estimate(of[metric]) for metric in METRICS), origin="rival")
        for (driver, method, allowed, queries), of in groups.items()
    ]
    return Table(
        "lead",
        "DriveGen-CS less each other adversary: share of scenes with a counted, and with an avoidable collision",
        ("driver", "DriveGen-CS less", "allowed", "runs", *METRICS),
        tuple(lines),
        (
            f"The same {rows[0]['n']} scenes, one seed, 95 % over recordings. Above 0 DriveGen-CS leads; where an interval "
            "holds 0, the two are not told apart.",
        ),
    )
