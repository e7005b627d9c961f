"""How often a driver fails in traffic that follows a law, from few runs: draws of the law are sorted by who else fails in them.

Other drivers, the *house*, whose runs are cheap, drive through many draws. A draw belongs to the stratum of how many of them
fail in it; how large each stratum is, is known from all draws. The driver in question is run in some draws of each stratum, more
in those where others fail. Its rate is the mean of its rates in the strata, weighted by their sizes: whatever the house is, it is
not biased, and the less the house knows, the wider is its interval.

Sources: stratified sampling with Neyman's allocation (Neyman, 1934); intervals of weighted sums of counts by the gamma
distribution, which cover at least as often as they say (Fay and Feuer, 1997); with one stratum these are exact (Garwood, 1936).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import gamma

from drivegen.core.intervals import LEVEL, Interval
from drivegen.core.settings import Count

EDGES = np.array([1, 2, 3, 5, 9])
"""The strata: none of the house fails, one, two, three or four, five to eight, more."""


@dataclass(frozen=True)
class Trial:
    """How intervals are tried. `runs` of a driver for one of ours, `plain` for one by plain simulation, `repetitions` of both."""

    runs: Count
    plain: Count
    repetitions: Count


@dataclass(frozen=True)
class Strata:
    """H strata of a law.

    Attributes:
        share: (H,) of all draws. expected: (H,) the rate that may be expected of a driver there, more than 0.
    """

    share: NDArray[np.float64]
    expected: NDArray[np.float64]

    @classmethod
    def of(cls, house: NDArray[np.bool_]) -> "Strata":
        """By which of the house fail in D draws: (D, M). Each of them stands once for a driver that is not known."""
        everyone = house.sum(axis=1)
        share = np.bincount(strata(house), minlength=len(EDGES) + 1) / len(house)
        failed, runs = np.full(len(share), 0.5), np.full(len(share), 1.0)  # a rate of 0 would leave a stratum out
        for own in house.T:
            stratum = np.searchsorted(EDGES, everyone - own, side="right")
            failed += np.bincount(stratum, own, len(share))
            runs += np.bincount(stratum, minlength=len(share))
        return cls(share, failed / runs)

    def allocate(self, runs: int) -> NDArray[np.int64]:
        """(H,) how many of `runs` to make in each stratum, by Neyman: at least one wherever there are draws."""
        there = self.share > 0
        wish = self.share * np.sqrt(self.expected * (1 - self.expected))
        wish = np.where(there, np.maximum(np.floor(wish / wish.sum() * runs), 1), 0)
        return np.asarray(wish, np.int64)


def strata(house: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(D,) the stratum of each draw, by which of the house (M,) fail in it: (D, M)."""
    return np.asarray(np.searchsorted(EDGES, house.sum(axis=1), side="right"), np.int64)


def rate(share: NDArray[np.floating], failed: NDArray[np.integer], runs: NDArray[np.integer]) -> Interval:
    """The rate with its interval from `failed` of `runs` in each stratum: (..., H) each, leading dimensions that of one interval.

    A stratum without runs has no share. Values are arrays where there are leading dimensions.
    """
    weight = np.divide(share, runs, out=np.zeros(np.broadcast_shapes(share.shape, runs.shape)), where=runs > 0)
    value, variance, most = (weight * failed).sum(-1), (weight**2 * failed).sum(-1), weight.max(-1)
    tail = (1 - LEVEL) / 2
    low = _quantile(tail, value, variance)
    return Interval(value, low, _quantile(1 - tail, value + most, variance + most**2))


def _quantile(level: float, mean: NDArray[np.floating], variance: NDArray[np.floating]) -> Any:
    """Of the gamma distribution; 0 where the mean is 0."""
    some = mean > 0
    mean, variance = np.where(some, mean, 1.0), np.where(some, variance, 1.0)
    return np.where(some, gamma.ppf(level, mean**2 / variance, scale=variance / mean), 0.0)


def verified(failed: NDArray[np.bool_], house: NDArray[np.bool_], trial: Trial, random: np.random.Generator) -> dict[str, Any]:
    """What becomes of the intervals of a driver where its true rate is known.

    The draws (D,) in which it `failed` are taken for the law itself: their mean is the rate that is looked for, and every
    repetition draws from them anew. `house` is (D, M).

    * `rate`: the true one. `runs`, `plain`: how many were made.
    * `covered`, `covered_plain`: share of the intervals that hold it. `width`, `width_plain`: their mean widths.
    * `saves`: how many plain runs have the variance of one of these.
    * `strata`: of each its share, the runs made in it, and the driver's rate there.
    """
    law, at, truth = Strata.of(house), strata(house), failed.mean()
    made = law.allocate(trial.runs)
    draws = np.bincount(at, minlength=len(made))
    within = np.divide(np.bincount(at, failed, len(made)), draws, out=np.zeros(len(made)), where=draws > 0)
    ours = rate(law.share, random.binomial(made, within, (trial.repetitions, len(made))), made)
    theirs = rate(np.ones(1), random.binomial(trial.plain, truth, (trial.repetitions, 1)), np.array([trial.plain]))
    variance = (law.share**2 * np.divide(within * (1 - within), made, out=np.zeros(len(made)), where=made > 0)).sum()
    return {
        "rate": float(truth),
        "runs": int(made.sum()),
        "plain": trial.plain,
        "covered": _holds(ours, truth),
        "covered_plain": _holds(theirs, truth),
        "width": float(np.mean(ours.high - ours.low)),
        "width_plain": float(np.mean(theirs.high - theirs.low)),
        "saves": float(truth * (1 - truth) / (variance * made.sum())) if variance > 0 else None,
        "strata": [
            {"share": s, "runs": n, "rate": p} for s, n, p in zip(law.share.tolist(), made.tolist(), within.tolist(), strict=True)
        ],
    }


def _holds(interval: Interval, truth: float) -> float:
    return float(np.mean((interval.low <= truth) & (truth <= interval.high)))
