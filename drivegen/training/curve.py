"""One row of a loss curve, apart from the loop so that reading it needs no torch."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LossRow:
    """Losses up to one step.

    Attributes:
        step: optimiser steps done.
        train: mean training loss since the row before.
        validation: loss of the averaged weights on the validation examples, with fixed noise.
    """

    step: int
    train: float
    validation: float
