"""Whether two kinds of traffic put the same drivers in the same order: Kendall's tau-b, beside what two halves of one kind reach.

A driver's rate in a kind of traffic is the mean over its scenes. Intervals resample recordings of both kinds and the drivers at
once. Kinds that are compared with one reference meet the same draws of it, of the drivers and, where they are of the same
recordings, of these, so their differences are paired.
A bootstrap adds ties and noise of its own: its draws lie a little nearer to zero than the value.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, counts, percentiles

_DIGITS = 9
"""Rates that agree to so many digits are ties: sums of the same terms in another order are not quite equal."""


@dataclass(frozen=True)
class Rates:
    """What happened to D drivers in S scenes.

    Attributes:
        values: (D, S) of each driver in each scene. recordings: (S,) that the scenes were cut from.
    """

    values: NDArray[np.float64]
    recordings: Sequence[str]

    def means(self, times: NDArray[np.floating]) -> NDArray[np.float64]:
        """(B, D) rates where each scene counts as often as `times` (B, S) says."""
        means: NDArray[np.float64] = np.round(times @ self.values.T / times.sum(axis=1, keepdims=True), _DIGITS)
        return means

    def drawn(self, draws: "Draws") -> NDArray[np.float64]:
        """(1 + draws, D) rates, first as they are, then with recordings resampled (of one recording the same again)."""
        return self.means(np.concatenate([np.ones((1, len(self.recordings))), draws.of(self.recordings)]))


@dataclass
class Draws:
    """`count` resamplings of recordings, the same for whoever asks for the same recordings."""

    count: int
    rng: np.random.Generator
    _times: dict[tuple[str, ...], NDArray[np.float64]] = field(default_factory=dict)

    def of(self, recordings: Sequence[str]) -> NDArray[np.float64]:
        """(count, S) how often each of S scenes comes, one recording a scene."""
        names, number = np.unique(np.asarray(recordings), return_inverse=True)
        key = tuple(names.tolist())
        if key not in self._times:
            self._times[key] = counts(len(names), self.count, self.rng)
        return self._times[key][:, number]


def kendall(first: NDArray[np.floating], second: NDArray[np.floating], times: NDArray[np.floating]) -> NDArray[np.float64]:
    """Tau-b (B,) between the rows of two tables (B, D), each driver as often as `times` (B, D) says; NaN where all are tied."""
    i, j = np.triu_indices(first.shape[1], 1)
    weight = times[:, i] * times[:, j]
    one, other = np.sign(first[:, i] - first[:, j]), np.sign(second[:, i] - second[:, j])
    untied = (weight * np.abs(one)).sum(axis=1) * (weight * np.abs(other)).sum(axis=1)
    agree = (weight * one * other).sum(axis=1)
    tau: NDArray[np.float64] = np.divide(agree, np.sqrt(untied), out=np.full(len(agree), np.nan), where=untied > 0)
    return tau


def agreements(real: Rates, kinds: Sequence[Rates], draws: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Tau (kinds, 1 + draws) of each kind of traffic with the real one: first the value, then the bootstrap draws."""
    shared, times = Draws(draws, rng), _drivers(len(real.values), draws, rng)
    reference = real.drawn(shared)
    return np.stack([kendall(reference, kind.drawn(shared), times) for kind in kinds])


def ceiling(real: Rates, draws: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Tau (1 + draws,) between halves of the real recordings: the mean over random splits, then each with drivers redrawn.

    Halves hold half of the scenes, so two data sets as large as the real one would agree better than this. NaN for one recording.
    """
    names, number = np.unique(np.asarray(real.recordings), return_inverse=True)
    if len(names) < 2:
        return np.full(1 + draws, np.nan)
    order = rng.permuted(np.tile(np.arange(len(names)), (draws, 1)), axis=1)
    half = (order < len(names) / 2)[:, number].astype(np.float64)
    halves = real.means(half), real.means(1 - half)
    times = _drivers(len(real.values), draws, rng)
    return np.concatenate([[np.nanmean(kendall(*halves, np.ones_like(times[1:])))], kendall(*halves, times[1:])])


def interval(drawn: NDArray[np.float64]) -> Interval:
    """The value and the central share of the draws of one row (1 + draws,)."""
    return Interval(float(drawn[0]), *percentiles(drawn[1:][np.isfinite(drawn[1:])]))


def _drivers(count: int, draws: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """How often each of `count` drivers comes: once, then in each of `draws` resamplings: (1 + draws, count)."""
    return np.concatenate([np.ones((1, count)), counts(count, draws, rng)])
