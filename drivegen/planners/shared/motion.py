"""From numbers to motion: a trajectory in its path's frame is a base that meets both ends, plus two residuals.

Along the path, speed is `profile.base_speed` plus the slope of a spline over time; across it, the offset is a function
of the distance gone, not of time, so a vehicle that stands neither slides sideways nor turns. `decode` turns residuals into
x, y, heading and velocity that start and end as asked; `fitting` finds those of logs.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import unit, wrap_angle
from drivegen.core.scenario import DT, Trajectories
from drivegen.planners.base import PlanRequests
from drivegen.planners.shared.easing import ease
from drivegen.planners.shared.paths import LARGEST_TURN, Doubles, Frames, carried_on
from drivegen.planners.shared.profile import base_speed

ALONG, ACROSS = 20.0, 2.0
"""Full sizes [m] of the residuals along and across the path, see `reach` and `sideways`."""

STEERED = 20.0
"""Way [m] on which a residual across has half of its full size."""

GRID = 101
"""Points at which residuals are tabulated over [0, 1]."""

SETTLING = 25.0
"""Heading errors at the ends are straightened out within this distance [m]."""

ROWS = 1024
"""Trajectories that are decoded at once: what is worked on stays in the processor's cache."""


@njit(cache=True)
def reach(distance: float, full: float) -> float:
    """Natural size [m] of a residual: the distance gone where that is short, `full` where it is long."""
    return distance * full / (distance + full)


@njit(cache=True)
def sideways(distance: float) -> float:
    """Natural size [m] of the residual across after `distance` [m], a number or an array: its square where that is short.

    So what it bends is of the same curvature, about 2 ACROSS / STEERED ** 2, however short the way.
    """
    return distance * distance * ACROSS / (distance * distance + STEERED * STEERED)


def lateral_ends(frames: Frames) -> Doubles:
    """(B, 4): offset [m] at start and goal, slope dd/ds at start and goal."""
    turn = np.clip(frames.turn, -LARGEST_TURN, LARGEST_TURN)
    slope = np.tan(turn) * np.maximum(1 - frames.curvature * frames.offset, 0.2)
    return np.concatenate([frames.offset, slope], axis=1)


@njit(cache=True)
def base_offset(gone: float, distance: float, ends: Doubles) -> tuple[float, float]:
    """Lateral base d [m] and dd/ds after `gone` of `distance` [m]: smoothstep plus the heading errors' decay."""
    d0, d1, slope0, slope1 = ends
    part, left = gone / distance, distance - gone
    d = d0 + (d1 - d0) * part * part * (3 - 2 * part)
    slope = (d1 - d0) * 6 * part * (1 - part) / distance
    settling = min(distance, SETTLING)
    if gone < settling:
        x = gone / settling
        d, slope = d + slope0 * gone * (1 - x) ** 2, slope + slope0 * (1 - x) * (1 - 3 * x)
    if left < settling:
        x = left / settling
        d, slope = d - slope1 * left * (1 - x) ** 2, slope + slope1 * (1 - x) * (1 - 3 * x)
    return d, slope


@dataclass(frozen=True)
class Residuals:
    """Residuals of B trajectories tabulated at GRID points of [0, 1], in the units of `decode`.

    Attributes:
        pace: (B, GRID) slope of the residual along, over the part of the time, relative to `reach`.
        offset, slope: (B, GRID) residual across and its slope, over the part of the distance, relative to `sideways`.
    """

    pace: NDArray[np.float32]
    offset: NDArray[np.float32]
    slope: NDArray[np.float32]


def decode(frames: Frames, requests: PlanRequests, residuals: Residuals, steps: int) -> Trajectories:
    """Motion (B, steps): from the initial state to the goal at its step, then straight on at the goal's speed.

    A goal that is not ahead of its vehicle is not reached: the vehicle stops where it is. Parked vehicles stay.
    """
    poses = np.empty((len(requests), 2, 3))
    poses[:, 0, :2], poses[:, 1, :2] = requests.position, requests.goal_position
    poses[:, 0, 2], poses[:, 1, 2] = requests.heading, requests.goal_heading
    columns = (
        frames.row, frames.axle, frames.start, np.where(requests.parked, 0.0, frames.distance), frames.duration, frames.speed,
        lateral_ends(frames), poses, np.stack([requests.speed, requests.goal_speed], axis=1).astype(np.float64),
        requests.goal_step.astype(np.int64), residuals.pace, residuals.offset, residuals.slope,
    )  # fmt: skip
    motion = Trajectories.empty(len(requests), steps)
    motion.valid[:] = True
    for low in range(0, len(requests), ROWS):
        rows = slice(low, low + ROWS)
        state = _decoded(frames.table, *(column[rows] for column in columns), steps)
        heading = wrap_angle(state[..., 2])
        heading[:, 0] = requests.heading[rows]
        motion.position[rows], motion.heading[rows] = state[..., :2], heading
        motion.velocity[rows] = state[..., 3:] * unit(heading)
    return motion


@njit(cache=True)
def _paced(distance: float, duration: float, speed: Doubles, pace: NDArray[np.float32], v: Doubles, gone: Doubles) -> None:
    """Fill speeds `v` and distances `gone` (steps + 1,) from base and residual: never backward, `distance` in the end.

    Where base plus residual would drive backward the vehicle stands, and what this adds to the distance is taken off the
    rest by a factor that leaves the speeds at both ends alone; if that would need too much, the residual is left out.
    """
    last = len(v) - 1
    size = reach(distance, ALONG) / duration
    for attempt in range(2):
        total, inner = 0.0, 0.0
        for k in range(last + 1):
            u = k / last
            x = u * (GRID - 1)
            i = min(int(x), GRID - 2)
            rest = (pace[i] + (x - i) * (pace[i + 1] - pace[i])) * size if attempt == 0 else 0.0
            v[k] = max(base_speed(u * duration, duration, distance, speed[0], speed[1]) + rest, 0.0)
            share = 0.5 if k in (0, last) else 1.0
            total += share * v[k] * DT
            inner += v[k] * DT * 4 * u * (1 - u)
        factor = (distance - total) / max(inner, 1e-9)
        if -0.6 < factor < 1.0:
            break
        factor = 0.0
    gone[0] = 0.0
    for k in range(last + 1):
        u = k / last
        v[k] *= 1 + factor * 4 * u * (1 - u)
        if k > 0:
            gone[k] = gone[k - 1] + (v[k - 1] + v[k]) * DT / 2
    if gone[last] > 0:
        gone *= distance / gone[last]


@njit(cache=True)
def _decoded(
    table: Doubles,
    row: NDArray[np.int64],
    axle: Doubles,
    start: Doubles,
    distance: Doubles,
    duration: Doubles,
    speed: Doubles,
    ends: Doubles,
    poses: Doubles,
    speeds: Doubles,
    goal_step: NDArray[np.int64],
    pace: NDArray[np.float32],
    offset: NDArray[np.float32],
    slope: NDArray[np.float32],
    steps: int,
) -> Doubles:
    """x, y, heading, speed (B, steps, 4)."""
    state = np.empty((len(row), steps, 4))
    for b in range(len(row)):
        last = goal_step[b]
        state[b, :, :3], state[b, :, 3] = poses[b, 0], 0.0
        if distance[b] > 0:
            v, gone = np.empty(last + 1), np.empty(last + 1)
            _paced(distance[b], duration[b], speed[b], pace[b], v, gone)
            ease(table[row[b]], start[b], axle[b], distance[b], v, gone)
            size = sideways(distance[b])
            for k in range(min(last + 1, steps)):
                x = gone[k] / distance[b] * (GRID - 1)
                i = min(int(x), GRID - 2)
                d, tilt = base_offset(gone[k], distance[b], ends[b])
                d += (offset[b, i] + (x - i) * (offset[b, i + 1] - offset[b, i])) * size
                tilt += (slope[b, i] + (x - i) * (slope[b, i + 1] - slope[b, i])) * size / distance[b]
                px, py, tx, ty, curvature, moved = carried_on(table[row[b]], start[b] + gone[k], axle[b])
                stretch = max(moved - curvature * d, 0.2)
                state[b, k, 0], state[b, k, 1] = px - d * ty, py + d * tx
                state[b, k, 2] = np.arctan2(ty, tx) + np.arctan(tilt / stretch)
                state[b, k, 3] = v[k] * np.hypot(stretch, tilt)
            _pin_ends(state[b, : min(last + 1, steps)], gone / distance[b], poses[b], last)
            cos, sin = np.cos(poses[b, 1, 2]), np.sin(poses[b, 1, 2])
            for k in range(last + 1, steps):
                on = speeds[b, 1] * DT * (k - last)
                state[b, k, 0], state[b, k, 1] = poses[b, 1, 0] + on * cos, poses[b, 1, 1] + on * sin
                state[b, k, 2], state[b, k, 3] = poses[b, 1, 2], speeds[b, 1]
            if last < steps:
                state[b, last, 3] = speeds[b, 1]
        state[b, 0, 3] = speeds[b, 0]
    return state


@njit(cache=True)
def _pin_ends(state: Doubles, part: Doubles, poses: Doubles, last: int) -> None:
    """Spread what is left between the curve's ends and the poses asked for over the way, so that both are exact."""
    gap = np.zeros((2, 3))
    for end in range(2):
        k = 0 if end == 0 else last
        if k < len(state):
            gap[end, :2] = poses[end, :2] - state[k, :2]
            gap[end, 2] = (poses[end, 2] - state[k, 2] + np.pi) % (2 * np.pi) - np.pi
    for k in range(len(state)):
        w = part[k] * part[k] * (3 - 2 * part[k])
        for axis in range(3):
            state[k, axis] += (1 - w) * gap[0, axis] + w * gap[1, axis]
