"""Figures as rows of a published file: their columns, rows grouped for a table, and what a row of an adversary is called."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple
from operator import itemgetter
from typing import Any

import numpy as np

from drivegen.core import plugins
from drivegen.core.intervals import Interval
from drivegen.report.sections.attack import OURS
from drivegen.report.table import ENDS

Figure = Mapping[str, Any]
"""A row of a published file: what it is of, its value, and the ends of its interval."""


def as_columns(interval: Interval, names: Sequence[str] = ENDS) -> dict[str, float | None]:
    """Value and ends by the `names` of their columns; None for what is not finite."""
    numbers = zip(names, astuple(interval), strict=True)
    return {name: float(number) if np.isfinite(number) else None for name, number in numbers}


def grouped(rows: Iterable[Figure], by: Sequence[str], within: Sequence[str]) -> dict[Any, dict[Any, Figure]]:
    """Rows by their columns `by`, in the order in which these come, and in each group by the columns `within`.

    A key of several columns is a tuple, that of one its value.
    """
    group, place = itemgetter(*by), itemgetter(*within)
    groups: dict[Any, dict[Any, Figure]] = {}
    for line in rows:
        groups.setdefault(group(line), {})[place(line)] = line
    return groups


def title_of(adversary: str) -> str:
    """An adversary in words."""
    return str(plugins.about("adversaries", adversary)["title"])


def origin_of(adversary: str) -> str:
    """The look of an adversary's row: "ours" or "rival"."""
    return "ours" if adversary == OURS else "rival"
