"""From motion to numbers: the residuals of logged tracks about the base of `motion`, as spline coefficients."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.scenario import DT, Trajectories
from drivegen.planners.base import PlanRequests
from drivegen.planners.shared.motion import ALONG, base_offset, lateral_ends, reach, sideways
from drivegen.planners.shared.paths import Doubles, Frames, located
from drivegen.planners.shared.profile import base_speed, spline

FARTHEST = 6.0
"""A log that strays farther from its path is none to learn from [m]."""

NOISE = 8.0
"""On ways shorter than this [m] what logs show across them is noise: steering would not show."""

STIFFNESS = 1e-4
"""Ridge on the spline coefficients, relative to the weight of the frames: gaps in a log are bridged smoothly."""

FINE = 2000
"""Intervals of the table from which spline values are taken when fitting."""

CHUNK = 256
"""Tracks that are fitted at once."""


@dataclass(frozen=True)
class Encoded:
    """Residuals of B logged tracks: along, across (B, COEFFICIENTS) spline coefficients, relative to `reach` and `sideways`.

    `usable` (B,) bool says whether the track moves and keeps to its path; the others are no examples.
    """

    along: Doubles
    across: Doubles
    usable: NDArray[np.bool_]


def encode(frames: Frames, requests: PlanRequests, motion: Trajectories) -> Encoded:
    """Fit the residuals of `motion` (B, T), masked, up to each request's goal step."""
    scored = motion.valid & (np.arange(motion.steps) <= requests.goal_step[:, None])
    ends = lateral_ends(frames)
    rest = _rest(
        frames.table, frames.row, frames.axle, frames.start, frames.distance, frames.duration, frames.speed, ends,
        motion.position.astype(np.float64), scored,
    )  # fmt: skip
    time, part, along, across, weight, offset = (rest[..., k] for k in range(6))
    usable = (frames.distance > 1.0) & ~requests.parked & (np.abs(offset).max(axis=1) < FARTHEST)
    distance = np.maximum(frames.distance, 1.0)[:, None]
    steered = frames.distance > NOISE
    return Encoded(
        fit_splines(time, along, scored.astype(np.float64)) / reach(distance, ALONG),
        fit_splines(part, across, weight * steered[:, None]) / sideways(np.maximum(distance, NOISE)),
        usable,
    )


def fit_splines(u: Doubles, rest: Doubles, weight: Doubles) -> Doubles:
    """Spline coefficients (B, C) whose curves come nearest to `rest` (B, T) at `u`, by weighted ridge regression."""
    table = spline(np.linspace(0.0, 1.0, FINE + 1))[0]
    fitted = []
    for low in range(0, len(u), CHUNK):
        value = table[np.rint(u[low : low + CHUNK] * FINE).astype(np.intp)]
        weighted = (value * weight[low : low + CHUNK, :, None]).swapaxes(1, 2)
        ridge = STIFFNESS * np.maximum(weight[low : low + CHUNK].sum(axis=1), 1e-9)
        normal = weighted @ value + ridge[:, None, None] * np.eye(table.shape[1])
        fitted.append(np.linalg.solve(normal, weighted @ rest[low : low + CHUNK, :, None])[..., 0])
    return np.concatenate(fitted) if fitted else np.zeros((0, table.shape[1]))


@njit(cache=True)
def _rest(
    table: Doubles,
    row: NDArray[np.int64],
    axle: Doubles,
    start: Doubles,
    distance: Doubles,
    duration: Doubles,
    speed: Doubles,
    ends: Doubles,
    position: Doubles,
    scored: NDArray[np.bool_],
) -> Doubles:
    """(B, T, 6) per seen frame: part of the time, of the distance, rest along, across, weight across, offset; else 0."""
    out = np.zeros((*scored.shape, 6))
    for b in range(len(row)):
        if distance[b] <= 0:
            continue
        s, base, before, last = start[b], 0.0, speed[b, 0], 0
        for k in range(scored.shape[1]):
            t = min(k * DT, duration[b])
            if k > 0:
                now = base_speed(t, duration[b], distance[b], speed[b, 0], speed[b, 1])
                base, before = base + (before + now) * DT / 2, now
            if not scored[b, k]:
                continue
            reached, d = located(
                table[row[b]], axle[b], position[b, k, 0], position[b, k, 1], s - 2.0, s + 5.0 * (k - last) + 2.0
            )
            gone = min(max(reached - start[b], 0.0), distance[b])
            level = base_offset(gone, distance[b], ends[b])[0]
            out[b, k, 0], out[b, k, 1], out[b, k, 2] = t / duration[b], gone / distance[b], reached - start[b] - base
            # Frames in which it stands say the same again and again, so each weighs as much as it moves.
            out[b, k, 3], out[b, k, 4], out[b, k, 5] = d - level, min(max(reached - s, 0.01), 2.0), d
            s, last = reached, k
    return out
