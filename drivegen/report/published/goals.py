"""Who ranks goals how well on each data set, all selectors that ran: what carries over to real driving, and what not."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from drivegen.metrics.pooled import envelope
from drivegen.report.averaged import vehicles_over
from drivegen.report.published.quality import cell
from drivegen.report.published.results import interval_of
from drivegen.report.sections.models import NOTES, SCORES
from drivegen.report.table import NOT_MEASURED, Table, number, row

_OWN = NOTES[:-1]
"""Without the label bias of a model that sees numbers: the table has no such column."""


def goals(name: str, title: str, selectors: Sequence[str], measured: Mapping[str, Sequence[Mapping[str, Any]]]) -> Table:
    """One row a selector, measured or not; `measured` holds by selector what its stage measured, one a training seed."""
    lines = []
    for selector in [*selectors, *sorted(set(measured) - set(selectors))]:
        runs = [run["moving"] for run in measured.get(selector, ())]
        cells = (cell(envelope([interval_of(run, key) for run in runs])) for key in SCORES)
        description = str(measured[selector][0].get("described", selector)) if runs else NOT_MEASURED
        count = number(int(runs[0]["vehicles"])) if runs else NOT_MEASURED
        lines.append(row(selector, description, count, *cells, origin="ours"))
    heads = ("selector", "chosen by", "vehicles", *SCORES.values())
    over = next((vehicles_over(runs[0]["moving"]) for runs in measured.values() if runs), ())
    notes = (*_OWN, *over, "Means over training seeds; an interval holds those of all seeds.", *_worse_than_chance(measured))
    return Table(f"goals-{name}", f"Choosing goals: {title}", heads, tuple(lines), notes)


def _worse_than_chance(measured: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    """A sentence for each selector to whom chosen goals come as a greater surprise than to one that knows nothing."""
    nll = {name: envelope([interval_of(run["moving"], "nll") for run in runs]).value for name, runs in measured.items()}
    chance = nll.get("random", np.nan)  # NaN, too, where no vehicle moves: nothing is above it
    return [
        f"In NLL the selector {name} is worse than choosing at random: {value:.2f} against {chance:.2f} nat."
        for name, value in sorted(nll.items())
        if value > chance
    ]
