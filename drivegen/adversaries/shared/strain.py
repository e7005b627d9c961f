"""How hard planned tracks accelerate, brake and turn: much that is legal for a moment is what hardly anybody does."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.scenario import DT, Trajectories

WINDOW = 5
"""[steps] Accelerations are means over half a second: what is shorter is noise of logs, too."""

USUAL = 2.0
"""[m/s2] Half of the vehicles of the corpus stay below 1.6 in all of 10 s, nine of ten below 3.8."""


def strain(motion: Trajectories) -> NDArray[np.float32]:
    """(E,) [m/s2] by how much the largest acceleration of each track (E, T), along and across together, is beyond USUAL."""
    hardest = _hardest(motion.position, motion.velocity, motion.valid)
    return np.asarray(np.maximum(hardest - USUAL, 0.0), np.float32)


@njit(cache=True)
def _hardest(position, velocity, valid):  # type: ignore[no-untyped-def]
    """(E,) [m/s2] largest mean acceleration of a WINDOW in tracks (E, T) that are there at both ends of its first and last step.

    Velocities are differences of positions, but for the first, which is the vehicle's own.
    """
    count, steps = valid.shape
    hardest, v, there = np.zeros(count), np.empty((steps, 2)), np.empty(steps, np.bool_)
    for e in range(count):
        v[0, 0], v[0, 1], there[0] = velocity[e, 0, 0], velocity[e, 0, 1], valid[e, 0]
        for t in range(1, steps):
            for axis in range(2):
                v[t, axis] = (np.float64(position[e, t, axis]) - np.float64(position[e, t - 1, axis])) / DT
            there[t] = valid[e, t] and valid[e, t - 1]
        for t in range(WINDOW, steps):
            if there[t] and there[t - WINDOW]:
                x, y = v[t, 0] - v[t - WINDOW, 0], v[t, 1] - v[t - WINDOW, 1]
                hardest[e] = max(hardest[e], np.sqrt(x * x + y * y) / (WINDOW * DT))
    return hardest
