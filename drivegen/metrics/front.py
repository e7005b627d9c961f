"""Which settings of which methods are worth having, where error and diversity pull apart."""

import numpy as np
from numpy.typing import NDArray


def on_front(error: NDArray[np.floating], diversity: NDArray[np.floating]) -> NDArray[np.bool_]:
    """(P,) the points that no other point beats: lower in error and no farther from a diversity ratio of 1, or the reverse.

    Error (P,) and diversity ratio (P,) of each method at each temperature; points that are not numbers are beaten.
    """
    known = np.isfinite(error) & np.isfinite(diversity)
    far = np.where(known, np.abs(diversity - 1), np.inf)
    error = np.where(known, error, np.inf)
    no_worse = (error <= error[:, None]) & (far <= far[:, None])
    better = (error < error[:, None]) | (far < far[:, None])
    beaten: NDArray[np.bool_] = np.logical_and(no_worse, better).max(axis=1, initial=False)
    front: NDArray[np.bool_] = np.logical_and(known, ~beaten)
    return front
