"""Distances between the distributions of generated and of logged motion, over a whole set of scenes.

Numbers are compared by the Wasserstein-1 distance, in their own unit: how far, on average, mass must be moved. They are kept as
counts in fine bins (values beyond the ends go to the end bins), scene by scene, so that intervals can resample them. A
scene's samples share one weight: K of them count as much as its log. Manoeuvres are compared by the Jensen-Shannon
divergence in bits: 0 for the same shares, 1 for nothing in common.

Headways are times to the box ahead at one's own speed, of those who follow one within LONGEST_HEADWAY and move; times to
collision and post-encroachment times are those below their limit. How often they occur is not in the distance, but in
`close_call` (share of vehicle steps with a time to collision below CLOSE_CALL).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.intervals import Draws, Interval, percentiles, stacked
from drivegen.metrics import encroachment
from drivegen.metrics.encroachment import post_encroachment
from drivegen.metrics.features import Features
from drivegen.metrics.labels import manoeuvre

BINS = 240
LONGEST_HEADWAY = 10.0
LONGEST_TIME_TO_COLLISION = 10.0
CLOSE_CALL = 1.5
MOVING = 1.0
"""Headways are taken above this speed [m/s]."""

RANGES = {
    "speed": (0.0, 48.0),
    "acceleration": (-12.0, 12.0),
    "lateral_acceleration": (-12.0, 12.0),
    "jerk": (-30.0, 30.0),
    "headway": (0.0, LONGEST_HEADWAY),
    "time_to_collision": (0.0, LONGEST_TIME_TO_COLLISION),
    "post_encroachment": (0.0, encroachment.LONGEST),
}
"""Ends of the bins: m/s, m/s2, m/s2, m/s3, s, s, s."""

MANOEUVRES = ("stationary", "stop", "straight", "left", "right", "u_turn", "shift_left", "shift_right")

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SceneCounts:
    """Counts of one scene, the log's in row 0, the samples' mean in row 1.

    Attributes:
        numbers: (Q, 2, BINS) in the order of RANGES. manoeuvres: (2, 8) numbers of vehicles, in the order of MANOEUVRES.
        close_call: (2,) share of vehicle steps with a time to collision below CLOSE_CALL.
    """

    numbers: Floats
    manoeuvres: Floats
    close_call: Floats

    @property
    def encounters(self) -> Floats:
        """(2,) number of pairs that have a post-encroachment time."""
        return np.asarray(self.numbers[list(RANGES).index("post_encroachment")].sum(axis=1))


def scene_counts(features: Features) -> SceneCounts:
    """Counts of one scene; `features` are K samples and, last, the log."""
    values = [_values(features[-1:]), _values(features[:-1])]
    weights = (1.0, 1.0 / (len(features.edge) - 1))
    numbers = np.stack(
        [
            np.stack([w * binned(v[name], low, high) for v, w in zip(values, weights, strict=True)])
            for name, (low, high) in RANGES.items()
        ]
    )
    manoeuvres = np.zeros((2, len(MANOEUVRES)))
    for row, part, weight in ((0, features.motion[-1:], weights[0]), (1, features.motion[:-1], weights[1])):
        for k, n in np.ndindex(part.valid.shape[:2]):
            manoeuvres[row, MANOEUVRES.index(manoeuvre(part[k, n]))] += weight
    close = [_close_calls(features[-1:]), _close_calls(features[:-1])]
    return SceneCounts(numbers, manoeuvres, np.array(close))


def _close_calls(features: Features) -> float:
    """Share of vehicle steps; NaN without any."""
    times = features.around.time_to_collision[features.known[1]]
    return float((times < CLOSE_CALL).mean()) if len(times) else np.nan


def _values(features: Features) -> dict[str, NDArray[np.float32]]:
    moves, around, (known, speeds, accelerations, jerks) = features.kinematics, features.around, features.known
    follows = speeds & (moves.speed > MOVING) & np.isfinite(around.gap)
    times = around.time_to_collision[speeds]
    headways = around.gap[follows] / moves.speed[follows]
    encounters = post_encroachment(features.motion, known)
    return {
        "speed": moves.speed[speeds],
        "acceleration": moves.acceleration[accelerations],
        "lateral_acceleration": moves.lateral[speeds],
        "jerk": moves.jerk[jerks],
        "headway": headways[headways < LONGEST_HEADWAY],
        "time_to_collision": times[times < LONGEST_TIME_TO_COLLISION],
        "post_encroachment": np.concatenate(encounters),
    }


def binned(values: NDArray[np.floating], low: float, high: float) -> Floats:
    """Counts (BINS,) of values over [low, high]; those beyond go to the end bins."""
    number = np.clip(((values - low) * (BINS / (high - low))).astype(np.int64), 0, BINS - 1)
    return np.bincount(number, minlength=BINS).astype(np.float64)


def wasserstein(counts: Floats, low: float, high: float) -> Floats:
    """Wasserstein-1 distances (...) of histograms (..., 2, BINS) over [low, high]; NaN where one of both is empty."""
    shares = _shares(counts)
    return np.asarray(np.abs(np.diff(np.cumsum(shares, axis=-1), axis=-2)[..., 0, :]).sum(axis=-1) * ((high - low) / BINS))


def jensen_shannon(counts: Floats) -> Floats:
    """Jensen-Shannon divergences (...) [bits] of counts (..., 2, C); NaN where one of both is empty."""
    shares = _shares(counts)
    middle = shares.mean(axis=-2, keepdims=True)
    ratio = np.where(shares > 0, shares / np.where(middle > 0, middle, 1), 1)
    return np.asarray(np.maximum((shares * np.log2(ratio)).sum(axis=-1).mean(axis=-1), 0.0))


def _shares(counts: Floats) -> Floats:
    total = counts.sum(axis=-1, keepdims=True)
    shares: Floats = np.divide(counts, total, out=np.full(counts.shape, np.nan), where=total > 0)
    return shares


def distances(
    scenes: Sequence[SceneCounts], recordings: Sequence[str], draws: int, rng: np.random.Generator
) -> dict[str, Interval]:
    """Distances over all scenes, by name, with bootstrap intervals that resample their `recordings`, one name a scene."""
    drawn = Draws.of(recordings, draws, rng)
    out = {
        name: _interval(*(wasserstein(counts, low, high) for counts in _resampled((scene.numbers[q] for scene in scenes), drawn)))
        for q, (name, (low, high)) in enumerate(RANGES.items())
    }
    manoeuvres = _resampled((scene.manoeuvres for scene in scenes), drawn)
    return out | {"manoeuvres": _interval(*(jensen_shannon(counts) for counts in manoeuvres))}


def distance(counts: Floats, low: float, high: float, times: Floats) -> Interval:
    """Wasserstein-1 distance of histograms (S, 2, BINS) over [low, high] added up over scenes, with its interval.

    `times` (D, S) is how often each scene comes in each draw.
    """
    drawn = _resampled(counts, Draws(times, np.arange(len(counts))))
    return _interval(*(wasserstein(some, low, high) for some in drawn))


def _resampled(counts: Iterable[Floats], draws: Draws) -> tuple[Floats, Floats]:
    """Sums over the scenes' counts, each (2, C): as they are (2, C), and of each draw (D, 2, C)."""
    total = np.zeros(0)

    def parts() -> Iterator[Floats]:
        nonlocal total
        for number, part in enumerate(stacked(counts)):
            total = total + part.sum(axis=0) if number else part.sum(axis=0)
            yield part

    drawn = draws.sums(parts())
    return total, drawn


def _interval(value: Floats, drawn: Floats) -> Interval:
    """A distance is above zero by chance alone: draws lie above the value, so the interval is widened to hold it."""
    low, high = percentiles(drawn[np.isfinite(drawn)])
    return Interval(float(value), min(low, float(value)), max(high, float(value)))
