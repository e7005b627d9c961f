"""A loss curve and its file, apart from the loop so that reading it needs no torch."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivegen.store.files import whole


@dataclass(frozen=True)
class LossRow:
    """Losses up to one step.

    Attributes:
        step: optimiser steps done.
        train: mean training loss since the row before.
        validation: loss of the averaged weights on the validation examples, with fixed noise.
        error: of the averaged weights' roll-outs on validation logs [m] (a planner's mean ADE), NaN where nobody asked.
    """

    step: int
    train: float
    validation: float
    error: float = float("nan")


GAIN = 0.01
"""A gain below this share is none: the error of so few scenes moves by more from row to row."""


def plateau(rows: Sequence[LossRow]) -> bool | None:
    """Whether the last third of the steps gained nothing: its least error is no more than GAIN below the least before.

    None where a part has fewer than two errors to choose from: such a curve says nothing.
    """
    before, after = ([row.error for row in rows if (row.step > rows[-1].step * 2 / 3) == late] for late in (False, True))
    if min(len(before), len(after)) < 2 or not np.isfinite([*before, *after]).all():
        return None
    return min(after) >= (1 - GAIN) * min(before)


def kept(rows: Sequence[LossRow]) -> LossRow:
    """Whose weights are kept where the best are: of the least error, of the least validation loss where nobody asked for it.

    The last row where there was nothing to validate on.
    """
    figures = [row.validation if math.isnan(row.error) else row.error for row in rows]
    return rows[-1] if any(math.isnan(figure) for figure in figures) else rows[figures.index(min(figures))]


def write_curve(path: Path, rows: Sequence[LossRow], error: str | None = None) -> None:
    """The curve as CSV: step, train, validation, and the rows' errors under the name `error` where one is given."""
    heads = ["step", "train", "validation", *([] if error is None else [error])]
    numbers = [(row.train, row.validation, *(() if error is None else (row.error,))) for row in rows]
    lines = [f"{row.step}," + ",".join(f"{value:.6f}" for value in values) for row, values in zip(rows, numbers, strict=True)]
    with whole(path) as temporary:
        temporary.write_text("\n".join([",".join(heads), *lines]) + "\n")
