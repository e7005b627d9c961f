"""Means over scenes, training and sampling seeds together: what a number would be on other scenes, trained and drawn once more.

Scenes of one recording share cars, so they are resampled together (cluster bootstrap), crossed with the training seeds and
with the sampling seeds (three-way: Owen, "The pigeonhole bootstrap", 2007, which is conservative).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, counts, percentiles, resamplings

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Resampling:
    """How often each seed and each scene is drawn, the same for all that is compared, so differences are paired.

    Attributes:
        runs: (D, S), the product of how often a run's two seeds are drawn. scenes: (D, N), those of one recording equally often.
    """

    runs: Floats
    scenes: Floats

    @classmethod
    def of(cls, runs: Sequence[tuple[int, int]], recordings: list[str], draws: int, rng: np.random.Generator) -> "Resampling":
        """D = `draws` resamples of S `runs` and of the distinct names in `recordings`, one name a scene.

        `runs` are pairs of a training and a sampling seed; each seed is drawn with all its runs. D = 0 where there is one
        recording only.
        """
        drawn = np.ones((draws, len(runs)))
        for seeds in zip(*runs, strict=True):
            names, number = np.unique(seeds, return_inverse=True)
            drawn *= counts(len(names), draws, rng)[:, number]
        scenes = resamplings(recordings, draws, rng)
        return cls(drawn[: len(scenes)], scenes)


def pooled_mean(values: Floats, resampling: Resampling) -> Interval:
    """Mean of `values` (S, N) over runs and scenes with its interval; NaN cells don't count.

    Where all that is known is of one recording there is no interval, however many seeds there are.
    """
    known = np.isfinite(values)
    count = known.sum()
    if count == 0:
        return Interval(np.nan, np.nan, np.nan)
    drawn = _drawn(np.where(known, values, 0.0), resampling)
    weight = _drawn(known.astype(np.float64), resampling)
    times = resampling.scenes[:, known.any(axis=0)]
    several = bool((times != times[:, :1]).any())  # recordings: scenes of one come equally often
    means = drawn[weight > 0] / weight[weight > 0]
    return Interval(float(values[known].mean()), *percentiles(means if several else means[:0]))


def envelope(intervals: list[Interval]) -> Interval:
    """One interval for a number of whole sets, one a run: their mean, from the lowest end to the highest. Wider than needed.

    Seeds without a number are left out; if one of the others has no ends (NaN), the envelope has none.
    """
    known = [interval for interval in intervals if np.isfinite(interval.value)]
    if not known:
        return Interval(np.nan, np.nan, np.nan)
    mean = float(np.mean([interval.value for interval in known]))
    return Interval(mean, float(np.min([i.low for i in known])), float(np.max([i.high for i in known])))


def rank_correlation(one: Floats, other: Floats) -> float:
    """Spearman's rho of two lists of M numbers, ties sharing their mean rank; NaN below three."""
    if len(one) < 3:
        return np.nan
    a, b = _ranks(one), _ranks(other)
    a, b = a - a.mean(), b - b.mean()
    spread = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / spread if spread > 0 else np.nan


def _drawn(values: Floats, resampling: Resampling) -> Floats:
    """Weighted sums (D,) of `values` (S, N)."""
    return np.asarray(((resampling.runs @ values) * resampling.scenes).sum(axis=1))


def _ranks(values: Floats) -> Floats:
    order = np.sort(values)
    return np.asarray(0.5 * (np.searchsorted(order, values, "left") + np.searchsorted(order, values, "right")))
