"""Goals for all vehicles of a scenario at once: each one's own odds, in the scenario's tempo, less what excludes one another.

The joint distribution is p(c_1 .. c_N | z) ~ prod_n p_n(c_n | z) * exp(-PENALTY * pairs that exclude each other), sampled by
Gibbs sweeps: vehicle after vehicle draws its goal anew, given what the others have drawn. The order is drawn anew for every
sweep of every sample, so nobody goes first: with sharp odds few sweeps do not mix, and in a fixed order the first would yield.
So a leader drives on for its follower as often as a follower stays behind. A goal of probability 0 is never drawn.

The tempo z is how far everybody gets in one sample: whether the light turns green, whether the queue dissolves. Logged
vehicles of one scene get farther, or less far, than their odds say together: the ranks of their logged goals correlate.
A Gaussian copula over these ranks draws them so and leaves each vehicle's own odds what they are.
"""

from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from drivegen.core import seeds

PENALTY = 8.0
"""A pair that excludes each other is exp(8), 3000 times, less likely."""

SWEEPS = 4
"""How often every vehicle draws again, given the others."""


def draw_together(
    used: NDArray[np.floating],
    start: NDArray[np.int64],
    exclusive: NDArray[np.bool_],
    noise: NDArray[np.float32],
    order: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Goals (K, N), counted within each vehicle's candidates.

    Args:
        used: (Q,) or, where samples differ, (K, Q) the vehicles' own probabilities, one vehicle's after the other's.
        start: (N + 1,) rows of each vehicle. exclusive: (Q, Q) bool. noise: (S + 1, K, Q) see `gumbel`.
        order: (S, K, N) of S sweeps, see `orders`.
    """
    with np.errstate(divide="ignore"):
        odds = np.ascontiguousarray(np.broadcast_to(np.log(used.astype(np.float64)), noise.shape[1:]))
    choice = np.zeros((noise.shape[1], len(start) - 1), np.int64)
    _sweep(odds, start, exclusive, noise, order, choice)
    return choice - start[:-1]


def gumbel(seed: int, scenario_id: str, samples: int, rows: int) -> NDArray[np.float32]:
    """(SWEEPS + 1, K, Q) Gumbel noise: the largest of log p + noise is a draw from p."""
    return seeds.rng(seed, "goals", scenario_id).gumbel(size=(SWEEPS + 1, samples, rows)).astype(np.float32)


def orders(random: np.random.Generator, sweeps: int, samples: int, vehicles: int) -> NDArray[np.int64]:
    """(S, K, N) in which order the vehicles of each sample draw again, sweep after sweep."""
    return random.random((sweeps, samples, vehicles)).argsort(axis=-1)


def tempos(seed: int, scenario_id: str, samples: int) -> NDArray[np.float64]:
    """(K,) standard normal, one in each of K equally likely ranges, so that few samples show slow scenes and brisk ones."""
    rng = seeds.rng(seed, "tempo", scenario_id)
    return np.asarray(ndtri((rng.permutation(samples) + rng.uniform(size=samples)) / samples))


def in_tempo(
    used: NDArray[np.float32], start: NDArray[np.int64], distance: NDArray[np.floating], tempo: NDArray[np.float64], share: float
) -> NDArray[np.float64]:
    """(K, Q) each vehicle's odds of its goals in samples of given tempo; their mean over all tempos are its own odds.

    A vehicle's goal is where Phi^-1 of its rank, by distance, is sqrt(share) * tempo + sqrt(1 - share) * noise of its own.

    Args:
        used: (Q,) own odds, one vehicle's after the other's. start: (N + 1,) rows of each vehicle.
        distance: (Q,) [m] of the goals. tempo: (K,) standard normal. share: of the variance, in [0, 1).
    """
    odds = np.empty((len(tempo), len(used)))
    for first, last in pairwise(start):
        nearest_first = first + np.argsort(distance[first:last], kind="stable")
        below = np.cumsum(used[nearest_first], dtype=np.float64)
        edges = ndtri(np.concatenate([[0.0], below / below[-1]]))
        odds[:, nearest_first] = np.diff(ndtr((edges - np.sqrt(share) * tempo[:, None]) / np.sqrt(1.0 - share)), axis=1)
    return odds


@njit(cache=True)
def _sweep(odds, start, exclusive, noise, order, choice):  # type: ignore[no-untyped-def]
    samples, count = choice.shape
    for k in range(samples):
        for n in range(count):
            choice[k, n] = start[n] + np.argmax(odds[k, start[n] : start[n + 1]] + noise[0, k, start[n] : start[n + 1]])
        for sweep in range(1, noise.shape[0]):
            for n in order[sweep - 1, k]:
                best, chosen = -np.inf, choice[k, n]
                for c in range(start[n], start[n + 1]):
                    score = odds[k, c] + noise[sweep, k, c]
                    for m in range(count):
                        if exclusive[c, choice[k, m]]:
                            score -= PENALTY
                    if score > best:
                        best, chosen = score, c
                choice[k, n] = chosen
