"""Means over runs of several seeds."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

ESTIMATE = ("value", "low", "high")


def over_seeds(data: str, runs: Sequence[Sequence[Mapping[str, Any]]]) -> Iterator[dict[str, Any]]:
    """The rows of all runs, each once, with `data`, their mean over runs and in `seeds` how many have it (`estimate_of`).

    Rows are the same if all else that they hold agrees; `n` is that of the first run that has the row.
    """
    same: dict[tuple[tuple[str, Any], ...], list[Mapping[str, Any]]] = {}
    for line in (line for run in runs for line in run):
        same.setdefault(tuple((name, value) for name, value in line.items() if name not in (*ESTIMATE, "n")), []).append(line)
    for lines in same.values():
        yield {"data": data, **lines[0], **estimate_of([[line[name] for name in ESTIMATE] for line in lines])}


def estimate_of(runs: Sequence[Sequence[float | None]]) -> dict[str, Any]:
    """{value, low, high, seeds} of a figure with its ends in each run: means over the runs in which it has a finite value.

    `seeds` is how many these are; the ends are None unless all of them have both, else a mean could lie outside them.
    """
    finite = [[None if x is None or not np.isfinite(x) else float(x) for x in run] for run in runs]
    measured = [run for run in finite if run[0] is not None]
    means = map(mean_of_all, zip(*measured, strict=True)) if measured else (None, None, None)
    return {**dict(zip(ESTIMATE, means, strict=True)), "seeds": len(measured)}


def mean_of_all(values: Sequence[float | bool | None]) -> float | None:
    """The mean over runs, None where one of them has none."""
    numbers = [float(value) for value in values if value is not None]
    return sum(numbers) / len(numbers) if len(numbers) == len(values) else None
