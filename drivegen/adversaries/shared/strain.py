"""How hard planned tracks accelerate, brake and turn: much that is legal for a moment is what hardly anybody does."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import DT, Trajectories

WINDOW = 5
"""[steps] Accelerations are means over half a second: what is shorter is noise of logs, too."""

USUAL = 2.0
"""[m/s2] Half of the vehicles of the corpus stay below 1.6 in all of 10 s, nine of ten below 3.8."""


def strain(motion: Trajectories) -> NDArray[np.float32]:
    """(E,) [m/s2] by how much the largest acceleration of each track (E, T), along and across together, is beyond USUAL."""
    position, there = motion.position.astype(np.float64), motion.valid[:, 1:] & motion.valid[:, :-1]
    velocity = np.concatenate([motion.velocity[:, :1], np.diff(position, axis=1) / DT], axis=1)
    change = np.linalg.norm(velocity[:, WINDOW:] - velocity[:, :-WINDOW], axis=-1) / (WINDOW * DT)
    there = np.concatenate([motion.valid[:, :1], there], axis=1)
    seen = there[:, WINDOW:] & there[:, :-WINDOW]
    hardest = np.where(seen, change, 0.0).max(axis=1, initial=0.0)
    return np.asarray(np.maximum(hardest - USUAL, 0.0), np.float32)
