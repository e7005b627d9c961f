"""How well a driver drives, over runs of the same driver (paper, "Downstream Optimization" and "Corner Case Quality").

With S runs (a run is one target in one scenario's traffic), run i valid for steps 0..E_i (its end or its collision),
positions p_i(t), speeds v_i(t) and accelerations a_i(t) = (v_i(t + 1) - v_i(t)) / dt:

* CR = share of runs that end in a collision. Counted apart: those that the driver is at fault for, those in which a replayed
  vehicle that can't brake ran into it from behind, overlaps at spawn, and crashes within the first second.
* Dis = mean over runs of sum_t |p_i(t + 1) - p_i(t)| [m]: the way until the end or the collision.
* Comfort, "the reciprocal of average linear acceleration": 1 / mean_i mean_t |a_i(t)| (`comfort_absolute`), or, read
  literally, 1 / |mean_i mean_t a_i(t)| (`comfort_signed`) [s2/m].
* Div, "the average standard deviation of trajectories in test scenarios", sigma(t) = sqrt(var x(t) + var y(t)) averaged over
  t: over all runs, each moved to the frame of its own first pose (`spread_over_runs`), or over the samples of one scenario,
  averaged over scenarios (`spread_over_samples`) [m]. A step counts where at least two runs are valid.
* Progress = Dis / mean way that the targets drive in the same traffic without the driver; the share of red lights run is of those
  that targets came near. Both are ratios of sums over scenarios.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import rotate
from drivegen.core.intervals import bootstrap_means, percentiles, resamplings
from drivegen.core.scenario import DT, Trajectories

NEIGHBOURS = {"replayed": "", "reactive": "reactive."}
"""Kinds of neighbours -> what names of metrics of runs among them begin with."""

RATIOS = (("progress", "distance", "planned_distance"), ("red_share", "red_run", "red_lights"))
"""Names of ratios, and of the metrics that they are of."""


@dataclass(frozen=True)
class RunNumbers:
    """Numbers of S runs, each (S,).

    Attributes:
        distance: Dis of the run [m].
        absolute_acceleration, acceleration: mean over its steps of |a| and of a [m/s2]; NaN for a run of one step.
        hardest_braking: largest -a [m/s2], 0 if it never braked, NaN for a run of one step.
        seconds: its length [s].
    """

    distance: NDArray[np.float64]
    absolute_acceleration: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    hardest_braking: NDArray[np.float64]
    seconds: NDArray[np.float64]


def run_numbers(motion: Trajectories) -> RunNumbers:
    """Numbers of each run from the targets' motion (S, T); invalid steps are not driven."""
    both = motion.valid[:, 1:] & motion.valid[:, :-1]
    moved = np.hypot(*np.moveaxis(np.diff(motion.position.astype(np.float64), axis=1), -1, 0))
    change = np.diff(motion.speed.astype(np.float64), axis=1) / DT
    steps = both.sum(axis=1)
    return RunNumbers(
        distance=np.where(both, moved, 0.0).sum(axis=1),
        absolute_acceleration=_mean(np.abs(change), both, steps),
        acceleration=_mean(change, both, steps),
        hardest_braking=np.where(steps > 0, np.where(both, -change, 0.0).max(axis=1, initial=0.0), np.nan),
        seconds=steps * DT,
    )


def driving_summary(
    metrics: Mapping[str, NDArray[np.float64]],
    recordings: Sequence[str],
    motion: Trajectories,
    scene: NDArray[np.integer],
    draws: int,
    rng: np.random.Generator,
) -> dict[str, float]:
    """Means with their ends "NAME.low" and "NAME.high" over recordings, both readings of Comfort, Div over all runs, counts.

    `metrics` holds each of C scenarios' mean over its runs, (C,) by name, `absolute_acceleration` and `acceleration` among
    them; `recordings` (C,) where each was cut from. `motion` (S, T) is that of the driven targets, `scene` (S,) the scenario
    of each run. Intervals come from `draws` bootstrap draws.
    """
    names, count = sorted(metrics), len(recordings)
    intervals = bootstrap_means(np.stack([metrics[name] for name in names], axis=1), recordings, draws, rng)
    out = {"scenarios": float(count), "recordings": float(len(set(recordings))), "runs": float(len(scene))}
    for name, interval in zip(names, intervals, strict=True):
        out |= {name: interval.value, f"{name}.low": interval.low, f"{name}.high": interval.high}
    out["comfort_absolute"] = comfort(out["absolute_acceleration"])
    out["comfort_signed"] = comfort(out["acceleration"])
    resampled = np.concatenate([np.ones((1, count)), resamplings(recordings, draws, rng)])
    for name, part, whole in RATIOS:
        if part in metrics and whole in metrics:
            known = np.isfinite(metrics[part]) & np.isfinite(metrics[whole])
            out |= _ratio(name, *(resampled[:, known] @ metrics[each][known] for each in (part, whole)))
    weights = resampled[:, scene]
    spread, *spreads = spread_over_runs(motion, weights)
    low, high = percentiles(np.array([draw for draw in spreads if np.isfinite(draw)]))  # some draws hold a single run
    return out | {"spread_over_runs": float(spread), "spread_over_runs.low": low, "spread_over_runs.high": high}


def _ratio(name: str, part: NDArray[np.float64], whole: NDArray[np.float64]) -> dict[str, float]:
    """The first of the ratios with the interval of the others; nothing where there is nothing to compare with."""
    if not whole[0] > 0:
        return {}
    value, *others = part[whole > 0] / whole[whole > 0]
    low, high = percentiles(np.array(others))
    return {name: float(value), f"{name}.low": low, f"{name}.high": high}


def comfort(mean_acceleration: float) -> float:
    """1 / |mean acceleration| [s2/m]; NaN where nothing accelerated at all."""
    return 1 / abs(mean_acceleration) if mean_acceleration and np.isfinite(mean_acceleration) else float("nan")


def spread_over_runs(motion: Trajectories, weights: NDArray[np.floating]) -> NDArray[np.float64]:
    """Div over S runs (S, T), each in its own first frame, for D weightings (D, S) of the runs (bootstrap counts, or ones)."""
    own = rotate(motion.position.astype(np.float64) - motion.position[:, :1], -motion.heading[:, :1].astype(np.float64))
    return _spread(own.astype(np.float64), motion.valid, weights)


def spread_over_samples(motion: Trajectories, scene: NDArray[np.integer]) -> NDArray[np.float64]:
    """Div of each of C scenes over its samples: (C,) for S runs (S, T) whose scene numbers (S,) are 0..C - 1.

    NaN for a scene with one sample.
    """
    count = int(scene.max(initial=-1)) + 1
    belongs = (scene == np.arange(count)[:, None]).astype(np.float64)
    first = motion.position[np.argmax(belongs, axis=1)][:, 0].astype(np.float64)
    return _spread(motion.position - first[scene][:, None], motion.valid, belongs)


def _spread(position: NDArray[np.float64], valid: NDArray[np.bool_], weights: NDArray[np.floating]) -> NDArray[np.float64]:
    """Weighted sigma(t) over runs, averaged over the steps at which two or more count: (D,)."""
    known = valid.astype(np.float64)
    total, runs = weights @ known, (weights > 0) @ known
    scale = np.maximum(total, 1e-12)
    variance = np.zeros_like(total)
    for axis in (0, 1):
        value = np.where(valid, position[..., axis], 0.0)
        mean = weights @ value / scale
        variance += np.maximum(weights @ value**2 / scale - mean**2, 0.0)
    counts = runs >= 2
    return _mean(np.sqrt(variance), counts, counts.sum(axis=1))


def _mean(values: NDArray[np.float64], mask: NDArray[np.bool_], count: NDArray[np.integer]) -> NDArray[np.float64]:
    """Mean (S,) over the masked entries of each row; NaN where there are none."""
    total = np.where(mask, values, 0.0).sum(axis=1)
    mean: NDArray[np.float64] = np.divide(total, count, out=np.full(len(total), np.nan), where=count > 0)
    return mean
