"""A realism score in the manner of Waymo's Sim Agents challenge, for data without its lights: "WOSAC-style, AV2".

How likely is the log under the samples, feature by feature? A vehicle's K samples make one histogram per feature over all its
steps; a feature's score is exp of the mean log likelihood of the logged values, in [0, 1]; the score is their weighted sum.
Features, bins, pseudocounts and weights are those of the challenge's 2025 configuration. What differs:

* the traffic light feature (weight 0.05) is dropped, and the other weights are divided by 0.95;
* K samples as the pipeline draws them, not 32 (each empty bin costs a little less), over the scenario's own horizon;
* steps that the log did not observe count for nobody, in the samples as in the log, nor do those of a sample that has left the
  map; the log's steps are all asked about;
* in two dimensions, at speeds taken over x and y.

So scores compare methods on the same scenarios with the same K, never with a leaderboard. The log itself does not reach 1: a
histogram over time is not certain of any step. Its row, a random walk's and constant velocity's are the anchors.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.metrics.features import Features

LIGHTS = 0.05
"""Weight of the feature that is dropped; the others are divided by 1 - LIGHTS."""

LONGEST_TIME_TO_COLLISION = 5.0
"""Longer times to collision, and none at all, count as this [s]."""

BERNOULLI_PSEUDOCOUNT = 0.001


@dataclass(frozen=True)
class Histogram:
    """How a feature over time is told apart: `bins` of equal width from `low` to `high`; values beyond go to the end bins.

    `order` says of how many central differences the feature is made: where its steps are known.
    """

    weight: float
    order: int
    low: float
    high: float
    bins: int
    pseudocount: float = 0.1


HISTOGRAMS = {
    "linear_speed": Histogram(0.05, 1, 0.0, 25.0, 10),
    "linear_acceleration": Histogram(0.05, 2, -12.0, 12.0, 11),
    "angular_speed": Histogram(0.05, 1, -0.628, 0.628, 11),
    "angular_acceleration": Histogram(0.05, 2, -3.14, 3.14, 11),
    "distance_to_nearest_object": Histogram(0.10, 0, -5.0, 40.0, 10),
    "time_to_collision": Histogram(0.10, 1, 0.0, 5.0, 10),
    "distance_to_road_edge": Histogram(0.05, 0, -20.0, 40.0, 10),
}
INDICATORS = {"collision": 0.25, "off_road": 0.25}
"""Features that are true of a vehicle or not: it touches another box, a corner of it leaves the road, at some step."""

WEIGHTS = {name: weight / (1 - LIGHTS) for name, weight in ({n: h.weight for n, h in HISTOGRAMS.items()} | INDICATORS).items()}


def realism(features: Features) -> dict[str, float]:
    """The score of one scene, under "score", and of each feature; `features` are K samples and, last, the log.

    NaN where the log has no step at which a feature is known.
    """
    scores = {}
    for name, values in _over_time(features).items():
        shape = HISTOGRAMS[name]
        known = np.ascontiguousarray(features.known[shape.order])
        total = _log_likelihood(values, known, shape.low, shape.high, shape.bins, shape.pseudocount)
        steps = known[-1].sum()
        scores[name] = float(np.exp(total / steps)) if steps else float("nan")
    scored = features.known[0]
    indicators: dict[str, NDArray[np.bool_]] = {
        "collision": np.less(features.around.nearest, 0),
        "off_road": np.greater(features.edge, 0),
    }
    for name, happens in indicators.items():
        ever = np.logical_and(happens, scored).max(axis=-1)
        scores[name] = bernoulli_likelihood(ever[:, scored[-1].max(axis=-1)])
    return {"score": sum(WEIGHTS[name] * value for name, value in scores.items()), **scores}


def bernoulli_likelihood(happens: NDArray[np.bool_]) -> float:
    """exp of the mean over vehicles of the log likelihood of what the log does, (K + 1, N) with the log last."""
    samples, logged = happens[:-1], happens[-1]
    agreeing = (samples == logged).sum(axis=0) + BERNOULLI_PSEUDOCOUNT
    return float(np.exp(np.log(agreeing / (len(samples) + 2 * BERNOULLI_PSEUDOCOUNT)).mean()))


def _over_time(features: Features) -> dict[str, NDArray[np.float32]]:
    moves, around = features.kinematics, features.around
    return {
        "linear_speed": moves.speed,
        "linear_acceleration": moves.acceleration,
        "angular_speed": moves.turning,
        "angular_acceleration": moves.angular_acceleration,
        "distance_to_nearest_object": around.nearest,
        "time_to_collision": np.minimum(around.time_to_collision, np.float32(LONGEST_TIME_TO_COLLISION)),
        "distance_to_road_edge": features.edge,
    }


@njit(cache=True, error_model="numpy")
def _log_likelihood(values, known, low, high, bins, pseudocount):  # type: ignore[no-untyped-def]
    """Sum over the N vehicles and known steps of the log likelihood of the last of the K + 1 samples, all (K + 1, N, T)."""
    total, per_unit = 0.0, bins / (high - low)
    samples = values.shape[0] - 1
    counts = np.empty(bins)
    for n in range(values.shape[1]):
        counts[:] = pseudocount
        for t in range(values.shape[2]):
            for k in range(samples):
                if known[k, n, t]:
                    counts[_bin(values[k, n, t], low, per_unit, bins)] += 1
        everything = np.log(counts.sum())
        for t in range(values.shape[2]):
            if known[samples, n, t]:
                total += np.log(counts[_bin(values[samples, n, t], low, per_unit, bins)]) - everything
    return total


@njit(cache=True, error_model="numpy")
def _bin(value, low, per_unit, bins):  # type: ignore[no-untyped-def]
    return min(max(int(np.floor((value - low) * per_unit)), 0), bins - 1)
