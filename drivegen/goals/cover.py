"""Choose a few places that stand for many: greedy maximum coverage.

Every place has a mass, the prior belief that a vehicle ends there. One chosen place covers all mass within `radius`.
Taking the place that covers most of what is not yet covered is within 1 - 1/e of the best choice (Nemhauser, Wolsey and
Fisher, 1978); it spaces places evenly where mass is, drops doubles of routes that share a stretch, and takes few where
little is believed.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray


def cover(
    position: NDArray[np.floating], mass: NDArray[np.floating], chosen: NDArray[np.intp], radius: float, most: int
) -> NDArray[np.intp]:
    """Up to `most` indices of places (Q, 2) [m]: `chosen` ones first, then the best; fewer once all mass is covered."""
    picked: NDArray[np.intp] = _cover(
        np.ascontiguousarray(position, np.float64), mass.astype(np.float64), chosen.astype(np.int64), radius**2, most
    )
    return picked


# Every inner loop goes along a row without a branch, so that a processor does many places at once. Sums keep their order.


@njit(cache=True)
def _neighbourhoods(x, y, squared):  # type: ignore[no-untyped-def]
    """(Q, Q) whether two places cover each other."""
    near = np.empty((len(x), len(x)), np.bool_)
    for i in range(len(x)):
        for j in range(len(x)):
            near[i, j] = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 <= squared
    return near


@njit(cache=True)
def _cover(position, mass, chosen, squared, most):  # type: ignore[no-untyped-def]
    count = len(mass)
    near = _neighbourhoods(position[:, 0].copy(), position[:, 1].copy(), squared)
    gain = np.zeros(count)
    for j in range(count):
        for i in range(count):
            gain[i] += mass[j] if near[j, i] else 0.0
    uncovered = np.ones(count, np.bool_)
    picked = np.empty(most, np.int64)
    total = 0
    while total < min(most, count):
        best = chosen[total] if total < len(chosen) else np.argmax(gain)
        if total >= len(chosen) and gain[best] <= 1e-9:
            break
        picked[total] = best
        total += 1
        _take(best, near, uncovered, gain, mass)
    return picked[:total]


@njit(cache=True)
def _take(best, near, uncovered, gain, mass):  # type: ignore[no-untyped-def]
    """Mark everything near place `best` as covered and take its mass off the gains of all others, in place."""
    for j in range(len(mass)):
        if uncovered[j] and near[best, j]:
            uncovered[j] = False
            for i in range(len(mass)):
                gain[i] -= mass[j] if near[j, i] else 0.0
