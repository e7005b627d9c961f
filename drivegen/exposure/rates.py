"""How often a driver fails in many draws of traffic, from few runs: it is run where it may fail, and a little everywhere.

Draws are sorted into strata by how near the others come to where the driver drove before (`pool`); how large each stratum is, is
known. First the driver is run in all of them as they come, then, in rounds, more often where it has failed. Its rate is the mean
of its rates in the strata, weighted by their sizes. Where nearness says nothing about failures, the interval is as wide as that
of plain simulation, or a little wider, and still holds.

Since it is run more where it fails, strata that looked harmless weigh too little, so a rate is found too low: with 2 000 runs by
9 % of one of 1 in 100, by 13 % of one of 1 in 240 and by 18 % of one of 1 in 500 (simulated; `bias` says how much), a fraction of
the interval's width. The interval holds; the figure in its middle errs on the unsafe side.

Sources: stratified sampling with Neyman's allocation (Neyman, 1934); intervals of weighted sums of counts by the gamma
distribution, which cover at least as often as they say (Fay and Feuer, 1997); with one stratum these are exact (Garwood, 1936).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import gamma

from drivegen.core.intervals import LEVEL, Interval
from drivegen.core.settings import Count

EDGES = np.array([0.01, 0.3, 0.6, 1.0, 1.5, 2.5, 4.0, 7.0, 12.0])
"""Between the strata [m]: from those in which the others drive into the driver's own way to those in which nobody comes near."""

FIRST, ROUNDS = 0.3, 4
"""The share of the runs that is made in draws as they come, and in how many rounds the rest follows."""

Run = Callable[[NDArray[np.int64]], NDArray[np.bool_]]
"""Run the driver in draws (R,) by number: whether it failed in each (R,)."""


@dataclass(frozen=True)
class Trial:
    """How intervals are tried. `runs` of a driver for one of ours, `plain` for one by plain simulation, `repetitions` of both."""

    runs: Count
    plain: Count
    repetitions: Count


@dataclass(frozen=True)
class Estimate:
    """A rate with 95 % over draws, and what it was made of: of each stratum (H,) its share of all draws, runs and failures."""

    rate: Interval
    share: NDArray[np.float64]
    runs: NDArray[np.int64]
    failed: NDArray[np.int64]


def estimate(near: NDArray[np.floating], run: Run, runs: int, random: np.random.Generator) -> Estimate:
    """The rate in N draws from at most `runs` of them, or a few more where these are fewer than twelve: one of each stratum.

    `near` (N,) [m] is how near the others come in each.
    """
    at = np.searchsorted(EDGES, near, side="right")
    size = np.bincount(at, minlength=len(EDGES) + 1)
    order = random.permutation(len(at))
    order = order[np.argsort(at[order], kind="stable")]  # stratum by stratum, in random order
    start, share = np.cumsum(size) - size, size / len(at)
    made, failed = np.zeros(len(size), np.int64), np.zeros(len(size), np.int64)
    more = np.minimum(np.maximum(FIRST * runs * share, 1), size).astype(np.int64)
    for turn in range(ROUNDS + 1):
        if turn:
            more = allocate(share, failed, made, max(runs - int(made.sum()), 0) // (ROUNDS + 1 - turn), size - made)
        picks = [order[low : low + some] for low, some in zip(start + made, more, strict=True)]
        bad = run(np.concatenate(picks))
        failed += np.bincount(np.repeat(np.arange(len(size)), more), bad, len(size)).astype(np.int64)
        made += more
    return Estimate(rate_of(share, failed, made), share, made, failed)


def allocate(
    share: NDArray[np.floating], failed: NDArray[np.integer], made: NDArray[np.integer], more: int, room: NDArray[np.integer]
) -> NDArray[np.int64]:
    """(H,) where to make `more` runs: towards Neyman's shares of all, by what is known after `failed` of those `made` (H,).

    No stratum gets more than it has `room` (H,) for; what one has none for goes to the others.
    """
    expected = (failed + 0.5) / (made + 1)
    wish, given = share * np.sqrt(expected * (1 - expected)), np.zeros(len(share), np.int64)
    while (left := given < room).any():
        done, still = np.where(left, made + given, 0), more - int(given.sum())
        wished = np.where(left, wish, 0.0)
        lacking = np.maximum(wished / wished.sum() * (done.sum() + still) - done, 0.0)
        total = lacking.sum()
        added = np.asarray(lacking * (still / total) if total > 0 else lacking, np.int64)
        within = np.minimum(added, room - given)
        given += within
        if (within == added).all():
            break
    return given


def rate_of(share: NDArray[np.floating], failed: NDArray[np.integer], runs: NDArray[np.integer]) -> Interval:
    """The rate with its interval, in 0 to 1, from `failed` of `runs` in each stratum (H,); one without runs has no share."""
    weight = np.divide(share, runs, out=np.zeros(len(runs)), where=runs > 0)
    value, variance, most = (weight * failed).sum(), (weight**2 * failed).sum(), weight.max()
    tail = (1 - LEVEL) / 2
    low = _quantile(tail, value, variance) if value > 0 else 0.0
    return Interval(float(value), low, min(_quantile(1 - tail, value + most, variance + most**2), 1.0))


def _quantile(level: float, mean: float, variance: float) -> float:
    """Of the gamma distribution."""
    return float(gamma.ppf(level, mean**2 / variance, scale=variance / mean))


def verified(
    failed: NDArray[np.bool_], near: NDArray[np.floating], trial: Trial, before: int, random: np.random.Generator
) -> dict[str, Any]:
    """What becomes of the intervals of a driver where its true rate is known: (S, D) draws of S scenes in which it `failed`.

    * `rate`: the true one. `runs`, `plain`: how many were made for an interval, the former on average, with those made `before`
      to know what is near.
    * `covered`, `covered_plain`: share of the intervals that hold it. `width`, `width_plain`: their mean widths.
    * `bias`: how much the mean of our estimates is off, as a share of the rate, None where that is 0.
    * `saves`: how many plain runs from the law itself have the variance of one of these, None where the rate is 0. Ours are from
      the D draws of each scene, which are themselves some of the law's: what these miss counts, too.
    * `strata`: of each its share and the driver's rate there.
    """
    chance, draws = failed.mean(axis=1), max(failed.shape[1], 2)
    missed = float((chance * (1 - chance)).sum() / (len(chance) ** 2 * (draws - 1)))
    failed, near = failed.ravel(), near.ravel()
    truth, at = float(failed.mean()), np.searchsorted(EDGES, near, side="right")
    found = [estimate(near, lambda picks: failed[picks], trial.runs, random) for _ in range(trial.repetitions)]
    counts = random.binomial(trial.plain, truth, trial.repetitions)
    plain = [rate_of(np.ones(1), counts[n : n + 1], np.array([trial.plain])) for n in range(trial.repetitions)]
    ours, runs = [one.rate for one in found], before + float(np.mean([one.runs.sum() for one in found]))
    values = np.array([one.value for one in ours])
    variance = float(values.var()) + missed
    size = np.bincount(at, minlength=len(EDGES) + 1)
    within = np.divide(np.bincount(at, failed, len(size)), size, out=np.zeros(len(size)), where=size > 0)
    return {
        "rate": truth,
        "runs": runs,
        "plain": trial.plain,
        "covered": _holds(ours, truth),
        "covered_plain": _holds(plain, truth),
        "width": float(np.mean([one.high - one.low for one in ours])),
        "width_plain": float(np.mean([one.high - one.low for one in plain])),
        "bias": float(values.mean() / truth - 1) if truth > 0 else None,
        "saves": truth * (1 - truth) / (variance * runs) if truth > 0 and variance > 0 else None,
        "strata": [{"share": s, "rate": p} for s, p in zip((size / len(at)).tolist(), within.tolist(), strict=True)],
    }


def _holds(intervals: list[Interval], truth: float) -> float:
    return float(np.mean([one.low <= truth <= one.high for one in intervals]))
