"""Means over runs of several seeds."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np


def over_seeds(data: str, runs: Sequence[Sequence[Mapping[str, Any]]]) -> Iterator[dict[str, Any]]:
    """The rows of the first run with `data` and `seeds`; value and ends are means over runs that have them, else None.

    Rows are the same if all else that they hold agrees; `n` is the first run's.
    """
    alike = [{_about(line): line for line in run} for run in runs]
    for line in runs[0]:
        same = [run[_about(line)] for run in alike if _about(line) in run]
        means = {name: mean_of_some([one[name] for one in same]) for name in ("value", "low", "high")}
        yield {"data": data, **line, **means, "seeds": len(same)}


def _about(line: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple((name, value) for name, value in line.items() if name not in ("value", "low", "high", "n"))


def mean_of_some(values: Sequence[float | None]) -> float | None:
    """The mean over runs that have a finite one, None where none has."""
    finite = [float(value) for value in values if value is not None and np.isfinite(value)]
    return float(np.mean(finite)) if finite else None


def mean_of_all(values: Sequence[float | bool | None]) -> float | None:
    """The mean over runs, None where one of them has none."""
    numbers = [float(value) for value in values if value is not None]
    return sum(numbers) / len(numbers) if len(numbers) == len(values) else None
