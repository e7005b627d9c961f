"""Tracks shifted across: a change of lane, or part of one, at a time of its own, while all else stays as it was planned.

A planner spreads a change of lane over all of the way to its goal, and a goal is a place, not a moment. So who is to move into a
driver's way beside it, at the moment when it is there, has to be told when.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import unit, wrap_angle
from drivegen.core.scenario import DT, Trajectories
from drivegen.core.settings import NotNegative, Positive


@dataclass(frozen=True)
class Shift:
    """What is drawn, uniformly.

    Attributes:
        most: [m] to either side; 0 for no shift at all. shortest, longest: [s] that it lasts. It begins anywhere in the track.
    """

    most: NotNegative
    shortest: Positive
    longest: Positive

    def draw(self, motion: Trajectories, random: np.random.Generator) -> Trajectories:
        """Each track (E, T), shifted once."""
        side, lasts, begins = random.uniform(size=(3, *motion.valid.shape[:1]))
        seconds = self.shortest + (self.longest - self.shortest) * lasts
        end = max((motion.steps - 1) * DT - self.shortest, 0.0)
        return shifted(motion, self.most * (2 * side - 1), end * begins, seconds)


def shifted(
    motion: Trajectories, offset: NDArray[np.floating], begin: NDArray[np.floating], seconds: NDArray[np.floating]
) -> Trajectories:
    """Tracks (E, T), each moved `offset` (E,) [m] to its left from `begin` (E,) [s] on within `seconds` (E,).

    How far it is across depends on how far it has come (a polynomial of fifth degree): who stands does not slide. The first
    step stays as it is.
    """
    way = np.zeros(motion.valid.shape)
    way[:, 1:] = np.cumsum(np.hypot(*np.moveaxis(np.diff(motion.position.astype(np.float64), axis=1), -1, 0)), axis=1)
    first = _after(way, begin)
    length = np.maximum(_after(way, begin + seconds) - first, 1e-3)[:, None]
    part = np.clip((way - first[:, None]) / length, 0.0, 1.0)
    across = offset[:, None] * part**3 * (10 - 15 * part + 6 * part**2)
    slope = offset[:, None] * 30 * part**2 * (1 - part) ** 2 / length
    heading = motion.heading.astype(np.float64)
    turning = np.zeros_like(way)
    turning[:, 1:] = wrap_angle(np.diff(heading, axis=1)) / DT
    left = np.stack([-np.sin(heading), np.cos(heading)], axis=-1)
    position = motion.position + across[..., None] * left
    speed = np.hypot(motion.speed - across * turning, motion.speed * slope)  # a bend is longer outside than inside
    heading = heading + np.arctan(slope)
    moved = Trajectories(
        position.astype(np.float32),
        heading.astype(np.float32),
        (speed[..., None] * unit(heading)).astype(np.float32),
        motion.valid.copy(),
    )
    same = across == 0  # to the bit what it was
    for name in ("position", "heading", "velocity"):
        getattr(moved, name)[same] = getattr(motion, name)[same]
    return moved


def _after(way: NDArray[np.float64], seconds: NDArray[np.floating]) -> NDArray[np.float64]:
    """(E,) [m] how far each (E, T) has come after so many seconds (E,)."""
    step = np.clip(seconds / DT, 0, way.shape[1] - 1)
    low = np.minimum(step.astype(np.int64), way.shape[1] - 2)
    row = np.arange(len(way))
    return np.asarray(way[row, low] + (step - low) * (way[row, low + 1] - way[row, low]))
