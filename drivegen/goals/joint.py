"""Goals for all vehicles of a scenario at once: each one's own odds, less goals that exclude one another.

The joint distribution is p(c_1 .. c_N) ~ prod_n p_n(c_n) * exp(-PENALTY * pairs that exclude each other), sampled by Gibbs
sweeps: vehicle after vehicle draws its goal anew, given what the others have drawn. Nobody goes first, so a leader drives
on for its follower as often as a follower stays behind. A goal of probability 0 is never drawn.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen import seeds

PENALTY = 8.0
"""A pair that excludes each other is exp(8), 3000 times, less likely."""

SWEEPS = 4


def draw_together(
    used: NDArray[np.float32], start: NDArray[np.int64], exclusive: NDArray[np.bool_], noise: NDArray[np.float32]
) -> NDArray[np.int64]:
    """Goals (K, N), counted within each vehicle's candidates.

    Args:
        used: (Q,) the vehicles' own probabilities, one vehicle's after the other's. start: (N + 1,) rows of each vehicle.
        exclusive: (Q, Q) bool. noise: (SWEEPS + 1, K, Q) see `gumbel`.
    """
    with np.errstate(divide="ignore"):
        odds = np.log(used.astype(np.float64))
    drawn = np.zeros((noise.shape[1], len(start) - 1), np.int64)
    _sweep(odds, start, exclusive, noise, drawn)
    return drawn - start[:-1]


def gumbel(seed: int, scenario_id: str, samples: int, rows: int) -> NDArray[np.float32]:
    """(SWEEPS + 1, K, Q) Gumbel noise: the largest of log p + noise is a draw from p."""
    return seeds.rng(seed, "goals", scenario_id).gumbel(size=(SWEEPS + 1, samples, rows)).astype(np.float32)


@njit(cache=True)
def _sweep(odds, start, exclusive, noise, drawn):  # type: ignore[no-untyped-def]
    samples, count = drawn.shape
    for k in range(samples):
        for n in range(count):
            drawn[k, n] = start[n] + np.argmax(odds[start[n] : start[n + 1]] + noise[0, k, start[n] : start[n + 1]])
        for sweep in range(1, noise.shape[0]):
            for n in range(count):
                best, chosen = -np.inf, drawn[k, n]
                for c in range(start[n], start[n + 1]):
                    score = odds[c] + noise[sweep, k, c]
                    for m in range(count):
                        if exclusive[c, drawn[k, m]]:
                            score -= PENALTY
                    if score > best:
                        best, chosen = score, c
                drawn[k, n] = chosen
