"""A loss curve and its file, apart from the loop so that reading it needs no torch."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from drivegen.store.files import whole


@dataclass(frozen=True)
class LossRow:
    """Losses up to one step.

    Attributes:
        step: optimiser steps done.
        train: mean training loss since the row before.
        validation: loss of the averaged weights on the validation examples, with fixed noise.
        error: what the averaged weights are good for in metres (a planner's mean ADE), NaN where nobody asked.
    """

    step: int
    train: float
    validation: float
    error: float = float("nan")


def write_curve(path: Path, rows: Sequence[LossRow]) -> None:
    """The curve as CSV: step, train, validation."""
    lines = ["step,train,validation", *(f"{row.step},{row.train:.6f},{row.validation:.6f}" for row in rows)]
    with whole(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n")
