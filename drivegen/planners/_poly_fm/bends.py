"""Paths without a route: a Bezier curve from pose to pose, bent by a smooth residual, and the motion along it.

With L the length of the Bezier curve and u the part of it, a path is B(u) + R(h0) r(u) reach(L): r is a spline in the
frame of the start whose value and slope vanish at both ends, so every path has the poses asked for. Speed along the path
is the same base and residual as along a route (`shared.motion`), so goals are exact and nobody drives backward.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.scenario import DT, Trajectories
from drivegen.planners.base import ROUTE_POINTS, PlanRequests
from drivegen.planners.shared.fitting import fit_splines
from drivegen.planners.shared.motion import ALONG, GRID, Residuals, reach
from drivegen.planners.shared.paths import Doubles, Frames, bezier_paths, laid, point_on
from drivegen.planners.shared.profile import base_speed

SIDEWAYS = 20.0
"""Full size [m] of the path's residual, see `shared.motion.reach`."""

FARTHEST = 40.0
"""A log that strays farther from its Bezier curve is none to learn from [m]."""

LEAST_MOVE = 0.2
"""A logged frame nearer to the last one that counted adds nothing to the path [m]: it may be noise."""

STEEPEST = 0.9
"""Bends are scaled down where the residual changes by more than this per metre of its curve: below 1 no path turns back."""

PARTS = 3
"""Points of a bent path between two of the residual's grid."""


@dataclass(frozen=True)
class Bent:
    """Residuals of B logged tracks: along, bend_x, bend_y (B, COEFFICIENTS) spline coefficients, `usable` (B,) bool."""

    along: Doubles
    bend_x: Doubles
    bend_y: Doubles
    usable: NDArray[np.bool_]


def poses(requests: PlanRequests) -> tuple[Doubles, Doubles]:
    """Start and goal (B, 3): x, y, heading."""
    return (
        np.column_stack([requests.position, requests.heading]).astype(np.float64),
        np.column_stack([requests.goal_position, requests.goal_heading]).astype(np.float64),
    )


def encode(requests: PlanRequests, motion: Trajectories) -> Bent:
    """Fit path and pace of `motion` (B, T), masked, up to each request's goal step."""
    start, goal = poses(requests)
    path, length = bezier_paths(start, goal)
    scored = motion.valid & (np.arange(motion.steps) <= requests.goal_step[:, None])
    speed = np.stack([requests.speed, requests.goal_speed], axis=1).astype(np.float64)
    duration = np.maximum(requests.goal_step, 1) * DT
    rest, gone = _rest(path, length, start, goal, speed, duration, motion.position.astype(np.float64), scored)
    time, part, along, x, y, weight = (rest[..., k] for k in range(6))
    strayed = np.hypot(x, y).max(axis=1)
    usable = (gone > 1.0) & (gone < ROUTE_POINTS - 2) & (length > 0.5) & ~requests.parked & (strayed < FARTHEST)
    size = reach(np.maximum(length, 1.0), SIDEWAYS)[:, None]
    return Bent(
        fit_splines(time, along, scored.astype(np.float64)) / reach(np.maximum(gone, 1.0), ALONG)[:, None],
        fit_splines(part, x, weight) / size,
        fit_splines(part, y, weight) / size,
        usable,
    )


def bent_frames(requests: PlanRequests, bend_x: NDArray[np.float32], bend_y: NDArray[np.float32]) -> Frames:
    """Frames of requests on paths of their own, bent by residuals (B, GRID), in the units of `encode`."""
    start, goal = poses(requests)
    path, length = bezier_paths(start, goal)
    size = reach(length, SIDEWAYS)
    change = np.hypot(np.diff(bend_x, axis=1), np.diff(bend_y, axis=1)).max(axis=1) * (GRID - 1)
    size = np.minimum(size, STEEPEST * length / np.maximum(change, 1e-6)).astype(np.float32)[:, None]
    table, gone = _bent(path, length, start, bend_x * size, bend_y * size)
    window = np.stack([gone - 1.0, gone + 1.0], axis=1)
    return Frames.on(table, np.arange(len(requests)), np.zeros(len(requests)), requests, window)


def straight_on(count: int, pace: NDArray[np.float32]) -> Residuals:
    """Residuals of B trajectories that stay on their paths."""
    nothing = np.zeros((count, GRID), np.float32)
    return Residuals(pace, nothing, nothing)


@njit(cache=True)
def _rest(
    path: Doubles,
    length: Doubles,
    start: Doubles,
    goal: Doubles,
    speed: Doubles,
    duration: Doubles,
    position: Doubles,
    scored: NDArray[np.bool_],
) -> tuple[Doubles, Doubles]:
    """(B, T, 6) per seen frame: part of the time, of the way, rest along, rest in x and y, weight; and ways gone (B,)."""
    out, gone = np.zeros((*scored.shape, 6)), np.zeros(len(length))
    for b in range(len(length)):
        s = np.zeros(scored.shape[1])
        x, y = start[b, 0], start[b, 1]
        for k in range(scored.shape[1]):
            move = np.hypot(position[b, k, 0] - x, position[b, k, 1] - y) if scored[b, k] else 0.0
            s[k] = gone[b] + move
            if move > LEAST_MOVE:
                gone[b], x, y = s[k], position[b, k, 0], position[b, k, 1]
        gone[b] += np.hypot(goal[b, 0] - x, goal[b, 1] - y)
        if gone[b] <= 0:
            continue
        base, before, last = 0.0, speed[b, 0], 0.0
        cos, sin = np.cos(start[b, 2]), np.sin(start[b, 2])
        for k in range(scored.shape[1]):
            t = min(k * DT, duration[b])
            if k > 0:
                now = base_speed(t, duration[b], gone[b], speed[b, 0], speed[b, 1])
                base, before = base + (before + now) * DT / 2, now
            if not scored[b, k]:
                continue
            part = min(s[k] / gone[b], 1.0)
            px, py, _, _, _ = point_on(path[b], part * length[b])
            dx, dy = position[b, k, 0] - px, position[b, k, 1] - py
            out[b, k, 0], out[b, k, 1], out[b, k, 2] = t / duration[b], part, s[k] - base
            out[b, k, 3], out[b, k, 4] = cos * dx + sin * dy, cos * dy - sin * dx
            out[b, k, 5] = min(max(s[k] - last, 0.01), 2.0)  # frames in which it stands say the same again and again
            last = s[k]
    return out, gone


@njit(cache=True)
def _bent(
    path: Doubles, length: Doubles, start: Doubles, bend_x: NDArray[np.float32], bend_y: NDArray[np.float32]
) -> tuple[Doubles, Doubles]:
    """Paths (B, ROUTE_POINTS, 2), points 1 m apart, straight on behind the goal; lengths (B,) up to the goal."""
    paths, lengths = np.empty((len(length), ROUTE_POINTS, 2)), np.empty(len(length))
    count = (GRID - 1) * PARTS
    for b in range(len(length)):
        cos, sin = np.cos(start[b, 2]), np.sin(start[b, 2])
        px, py = start[b, 0], start[b, 1]
        paths[b, 0, 0], paths[b, 0, 1] = px, py
        filled, gone = 1, 0.0
        for k in range(1, count + 1):
            i, f = min(k // PARTS, GRID - 2), k / PARTS - min(k // PARTS, GRID - 2)
            dx = bend_x[b, i] + f * (bend_x[b, i + 1] - bend_x[b, i])
            dy = bend_y[b, i] + f * (bend_y[b, i + 1] - bend_y[b, i])
            x, y, _, _, _ = point_on(path[b], length[b] * k / count)
            x, y = x + cos * dx - sin * dy, y + sin * dx + cos * dy
            filled, gone = laid(paths[b], filled, gone, px, py, x, y)
            px, py = x, y
        _, _, tx, ty, _ = point_on(path[b], length[b])
        for k in range(filled, ROUTE_POINTS):
            paths[b, k, 0], paths[b, k, 1] = px + (k - gone) * tx, py + (k - gone) * ty
        lengths[b] = gone
    return paths, lengths
