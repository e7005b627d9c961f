"""Who ranks goals how well on each data set, all selectors that ran: what carries over to real driving, and what not."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from drivegen.metrics.intervals import Interval
from drivegen.metrics.pooled import envelope
from drivegen.report.averaged import vehicles_over
from drivegen.report.sections.models import NOTES, SCORES, SELECTORS
from drivegen.report.table import NOT_MEASURED, Cell, Table, number, row

_OWN = NOTES[:-1]
"""Without the label bias of a model that sees numbers: the table has no such column."""


def goals(name: str, title: str, found: Mapping[str, Sequence[Mapping[str, Any]]]) -> Table:
    """One row a selector; `found` holds by selector what its stage measured, one a training seed."""
    lines = []
    for selector in [*SELECTORS, *sorted(set(found) - set(SELECTORS))]:
        runs = [run["moving"] for run in found.get(selector, ())]
        said = str(found[selector][0].get("described", selector)) if runs else NOT_MEASURED
        count = number(int(runs[0]["vehicles"])) if runs else NOT_MEASURED
        lines.append(row(selector, said, count, *(_cell(runs, key) for key in SCORES), origin="ours"))
    heads = ("selector", "chosen by", "vehicles", *SCORES.values())
    over = next((vehicles_over(runs[0]["moving"]) for runs in found.values() if runs), ())
    notes = (*_OWN, *over, "Means over training seeds; an interval holds those of all seeds.", *_worse_than_chance(found))
    return Table(f"goals-{name}", f"Choosing goals: {title}", heads, tuple(lines), notes)


def _worse_than_chance(found: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    """A sentence for each selector to whom chosen goals come as a greater surprise than to one that knows nothing."""
    nll = {selector: float(np.mean([run["moving"]["nll"] for run in runs])) for selector, runs in found.items() if runs}
    chance = nll.get("random", np.inf)
    return [
        f"In NLL the selector {name} is worse than choosing at random: {value:.2f} against {chance:.2f} nat."
        for name, value in sorted(nll.items())
        if value > chance
    ]


def _cell(runs: Sequence[Mapping[str, Any]], key: str) -> Cell:
    ends = (".low", ".high")
    known = [Interval(float(run[key]), *(float(run.get(f"{key}{end}", np.nan)) for end in ends)) for run in runs if key in run]
    pooled = envelope(known)
    if not np.isfinite(pooled.value):
        return Cell(NOT_MEASURED)
    text = f"{pooled.value:.2f}"
    return Cell(text, f"{pooled.low:.2f} to {pooled.high:.2f}") if np.isfinite(pooled.low) else Cell(text)
