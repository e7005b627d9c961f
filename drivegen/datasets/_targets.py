"""Which tracks of a recording full of cars become targets, where the recording itself names none.

Any vehicle may be one that is seen for long and moves: without that there is nothing to compare with. That is all that the
future decides. A scenario is a target with its nearest neighbours, so among these targets are chosen greedily for what
their first frames show: again and again the one whose neighbourhood holds most vehicles that no scenario has yet.
"""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Trajectories, VehicleKind

LONG = 80
"""A target is seen for so many steps from the first one on (8 s), or as long as any if none is."""

NEIGHBOURHOOD = 16
"""Vehicles of a scenario, as selected by default: more or fewer only change how much scenarios have in common."""

LEAST_NEW = 4
"""A scenario that would show fewer vehicles that no other shows isn't worth having."""

MOVING = 5.0
"""A target travels at least so far [m], if there is one that does."""

_KINDS = (VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS)


def spread_targets(kind: NDArray[np.uint8], motion: Trajectories) -> list[int]:
    """Rows of the targets among M tracks `kind` (M,), `motion` (M, T), in the order in which they were chosen.

    Ties go to the one whose neighbourhood is smaller, so the more central one, then to the lower row. Empty if no vehicle
    is there at the first step.
    """
    steps_seen = np.where(np.isin(kind, _KINDS), np.cumprod(motion.valid, axis=-1).sum(-1), 0)
    if not steps_seen.any():
        return []
    long = steps_seen >= min(LONG, steps_seen.max())
    seen = motion.valid[:, 1:] & motion.valid[:, :-1]
    travelled = np.where(seen, np.hypot(*np.moveaxis(np.diff(motion.position, axis=1), -1, 0)), 0).sum(-1)
    fit = long & (travelled >= min(MOVING, travelled[long].max()))
    near, reach = _neighbourhoods(np.flatnonzero(steps_seen > 0), motion.position[:, 0])
    missing = steps_seen > 0
    chosen: list[int] = []
    while True:
        gain = np.where(fit, (near & missing).sum(-1), 0)
        if gain.max() < (LEAST_NEW if chosen else 1):
            return chosen
        best = np.flatnonzero(gain == gain.max())
        target = int(best[np.argmin(reach[best])])
        chosen.append(target)
        missing &= ~near[target]
        fit[target] = False


def _neighbourhoods(rows: NDArray[np.intp], position: NDArray[np.float32]) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """(M, M) which of `rows` are among each one's nearest, itself included; (M,) distance of the farthest of those [m]."""
    count = len(position)
    near, reach = np.zeros((count, count), np.bool_), np.full(count, np.inf)
    for row in rows.tolist():
        far = np.hypot(*(position[rows] - position[row]).T)
        nearest = np.argsort(far, kind="stable")[:NEIGHBOURHOOD]
        near[row, rows[nearest]] = True
        reach[row] = far[nearest].max()
    return near, reach
