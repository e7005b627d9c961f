"""Where to look at traffic from above: a square window that holds what matters of it."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET, Trajectories

_MARGIN = 10.0
"""Around what is shown [m]."""


def window(motion: Trajectories, narrowest: float, widest: float) -> tuple[NDArray[np.float64], float]:
    """Centre (2,) and width [m] of a window around all valid motion (..., N, T).

    Of motion that takes more than `widest` metres it holds those where most vehicles are longest, and always the target's
    beginning, if it is ever there. Raises UnusableInput where nobody is.
    """
    points = motion.position[motion.valid]
    if not len(points):
        raise UnusableInput("no vehicle is there at any step: there is nothing to be looked at", reason="no-motion")
    target = motion.position[..., TARGET, :, :][motion.valid[..., TARGET, :]]
    start = (target if len(target) else points)[0]
    extent = float(np.ptp(points, axis=0).max()) + 2 * _MARGIN
    width = float(np.clip(extent, narrowest, widest))
    centre = [_busiest(points[:, axis], float(start[axis]), width - 2 * _MARGIN) for axis in (0, 1)]
    return np.array(centre), width


def _busiest(values: NDArray[np.floating], within: float, width: float) -> float:
    """The middle of the interval of `width` that holds most of `values` (n,), of those that hold `within`."""
    low, high = float(values.min()), float(values.max())
    if high - low <= width:
        return (low + high) / 2
    ordered = np.sort(values)
    begins = np.clip(ordered, within - width, within)
    held = np.searchsorted(ordered, begins + width, "right") - np.searchsorted(ordered, begins, "left")
    return float(begins[held.argmax()] + width / 2)
