"""Paths: the smooth lines that motion is described along, and where on them a request begins and ends.

A path is a table of points 1 m apart, read as a cubic through them with central-difference tangents, so that position
and heading are continuous. Routes become paths by three passes of the binomial filter 1 4 6 4 1 (about 1.7 m wide):
centrelines are polygons, and their corners would be felt as jerks. Of a long vehicle the axles keep to the route, so that its
middle cuts bends: with its middle on the route it would sweep off the road. Where no route fits, the path is a cubic Bezier
curve from pose to pose.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import wrap_angle
from drivegen.core.scenario import DT
from drivegen.planners.base import ROUTE_POINTS, PlanRequests

Doubles = NDArray[np.float64]

LARGEST_TURN = 1.2
"""Headings at the ends differ from the path's by no more than this [rad] when the offset is shaped."""

LONG = 6.0
"""A vehicle longer than this [m] has axles; a shorter one keeps to its path with its middle."""

WHEELBASE = 0.8
"""Distance between the axles, one as far before a vehicle's middle as the other behind, as a part of its length.

More than of real ones, some 0.6: rear wheels cut in behind the front ones, as SUMO's logs do (`LOG.md`, long vehicles).
"""

SEARCH = 8.0
"""A request's ends lie on the path within this distance [m] of where it says."""


@dataclass(frozen=True)
class Frames:
    """B requests in the coordinates of their paths: s along, d to the left.

    Attributes:
        table: (R, ROUTE_POINTS, 2) [m] smooth paths: the routes, then one Bezier path per request without a route.
        row: (B,) int64 the path of each request. axle: (B,) [m] from a vehicle's middle to its axles, see `carried_on`.
        start, distance: (B,) [m] where it begins on its path and how far it goes; 0 for a goal that is not ahead.
        offset: (B, 2) d at start and goal [m]. turn: (B, 2) heading there, relative to the path's [rad].
        curvature: (B, 2) of the path there [1/m]. speed: (B, 2) along the path there [m/s], 0 or more.
        duration: (B,) [s] until the goal.
    """

    table: Doubles
    row: NDArray[np.int64]
    axle: Doubles
    start: Doubles
    distance: Doubles
    offset: Doubles
    turn: Doubles
    curvature: Doubles
    speed: Doubles
    duration: Doubles

    @classmethod
    def of(cls, requests: PlanRequests) -> "Frames":
        """Frames of all requests."""
        table, row, bezier_length = _table(requests)
        has_axles = (requests.size[:, 0] > LONG) & (requests.route >= 0)
        axle = np.where(has_axles, requests.size[:, 0].astype(np.float64) * WHEELBASE / 2, 0.0)
        return cls.on(table, row, axle, requests, _goal_window(requests, bezier_length))

    @classmethod
    def on(cls, table: Doubles, row: NDArray[np.int64], axle: Doubles, requests: PlanRequests, window: Doubles) -> "Frames":
        """Frames of requests on paths `table` (R, ROUTE_POINTS, 2): `row`, `axle` (B,), goals between s `window` (B, 2)."""
        poses = [
            np.column_stack([position, heading]).astype(np.float64)
            for position, heading in ((requests.position, requests.heading), (requests.goal_position, requests.goal_heading))
        ]
        s, offset, path_heading, curvature, pace = np.moveaxis(_ends(table, row, axle, poses[0], poses[1], window), -1, 0)
        turn = np.asarray(wrap_angle(np.stack([poses[0][:, 2], poses[1][:, 2]], axis=1) - path_heading), np.float64)
        speed = np.stack([requests.speed, requests.goal_speed], axis=1).astype(np.float64)
        along = np.maximum(speed * np.cos(turn), 0.0) / np.maximum(pace - curvature * offset, 0.2)
        distance = np.maximum(s[:, 1] - s[:, 0], 0.0)
        return cls(table, row, axle, s[:, 0], distance, offset, turn, curvature, along, np.maximum(requests.goal_step, 1) * DT)


def _table(requests: PlanRequests) -> tuple[Doubles, NDArray[np.int64], Doubles]:
    """All paths, the row of each request, the lengths of the Bezier paths."""
    used, row = np.unique(requests.route, return_inverse=True)
    free = requests.route < 0
    has_free = bool(free.any())
    smooth = _smoothed(requests.route_line[used[int(has_free) :]])
    row = row.astype(np.int64) - int(has_free)
    row[free] = len(smooth) + np.arange(free.sum())
    start = np.column_stack([requests.position, requests.heading])[free].astype(np.float64)
    goal = np.column_stack([requests.goal_position, requests.goal_heading])[free].astype(np.float64)
    bezier, length = bezier_paths(start, goal)
    return np.concatenate([smooth, bezier]), row, length


def _goal_window(requests: PlanRequests, bezier_length: Doubles) -> Doubles:
    """(B, 2) least and greatest s of the goal; a Bezier path may come by its goal twice, so there it is narrow."""
    free = requests.route < 0
    guess = requests.goal_s.astype(np.float64)
    guess[free] = bezier_length
    window = np.where(free, 1.0, SEARCH)
    return np.stack([guess - window, guess + window], axis=1)


@njit(cache=True)
def _smoothed(lines: NDArray[np.float32]) -> Doubles:
    """Binomially filtered lines (R, P, 2), continued straight at both ends so that these stay where they are."""
    count = lines.shape[1]
    smooth, padded = np.empty(lines.shape), np.empty(count + 4)
    for r in range(len(lines)):
        for axis in range(2):
            padded[2:-2] = lines[r, :, axis]
            for _ in range(3):
                _continue(padded)
                for k in range(count):
                    near = padded[k] + 4 * padded[k + 1] + 6 * padded[k + 2]
                    smooth[r, k, axis] = (near + 4 * padded[k + 3] + padded[k + 4]) / 16
                padded[2:-2] = smooth[r, :, axis]
    return smooth


@njit(cache=True)
def _continue(line: Doubles) -> None:
    """Continue numbers (P + 4,) straight on by two at either end."""
    line[0], line[1] = 3 * line[2] - 2 * line[3], 2 * line[2] - line[3]
    line[-2], line[-1] = 2 * line[-3] - line[-4], 3 * line[-3] - 2 * line[-4]


@njit(cache=True)
def laid(path: Doubles, filled: int, gone: float, px: float, py: float, x: float, y: float) -> tuple[int, float]:
    """Lay the points of `path` (P, 2), 1 m apart along a finer line, that lie on its stretch from (px, py) to (x, y).

    `filled` points are there before the stretch, which begins `gone` metres along the line; returns both for after it.
    """
    step = np.hypot(x - px, y - py)
    while step > 0 and gone + step >= filled and filled < len(path):
        part = (filled - gone) / step
        path[filled, 0], path[filled, 1] = px + part * (x - px), py + part * (y - py)
        filled += 1
    return filled, gone + step


@njit(cache=True)
def bezier_paths(start: Doubles, goal: Doubles) -> tuple[Doubles, Doubles]:
    """Paths (B, P, 2) from pose to pose (B, 3) and their lengths; pulled wider the more they turn, straight on behind."""
    paths, length = np.empty((len(start), ROUTE_POINTS, 2)), np.empty(len(start))
    for b in range(len(start)):
        x0, y0, h0 = start[b]
        x3, y3, h3 = goal[b]
        away = np.hypot(x3 - x0, y3 - y0)
        reach = away * (0.5 - np.cos(h3 - h0) / 6)
        x1, y1, x2, y2 = x0 + reach * np.cos(h0), y0 + reach * np.sin(h0), x3 - reach * np.cos(h3), y3 - reach * np.sin(h3)
        paths[b, 0, 0], paths[b, 0, 1] = x0, y0
        filled, gone, px, py = 1, 0.0, x0, y0
        fine = max(int(16 * away), 16)
        for k in range(1, fine + 1):
            t = k / fine
            a, c, e, g = (1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t * t, t**3
            x, y = a * x0 + c * x1 + e * x2 + g * x3, a * y0 + c * y1 + e * y2 + g * y3
            filled, gone = laid(paths[b], filled, gone, px, py, x, y)
            px, py = x, y
        for k in range(filled, ROUTE_POINTS):
            paths[b, k, 0], paths[b, k, 1] = x3 + (k - gone) * np.cos(h3), y3 + (k - gone) * np.sin(h3)
        length[b] = gone
    return paths, length


@njit(cache=True)
def point_on(line: Doubles, s: float) -> tuple[float, float, float, float, float]:
    """x, y, unit tangent, curvature of the path `line` (P, 2) at s [m]: its first point before it, straight on beyond it."""
    last = len(line) - 1
    beyond = max(s - last, 0.0)
    s = min(max(s, 0.0), last - 1e-6)
    i = int(s)
    f = s - i
    before, after = max(i - 1, 0), min(i + 2, last)
    half0, half1 = 1.0 / (i + 1 - before), 1.0 / (after - i)
    ax, ay = (line[i + 1, 0] - line[before, 0]) * half0, (line[i + 1, 1] - line[before, 1]) * half0
    bx, by = (line[after, 0] - line[i, 0]) * half1, (line[after, 1] - line[i, 1]) * half1
    dx, dy = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
    x = line[i, 0] + f * (ax + f * (3 * dx - 2 * ax - bx + f * (ax + bx - 2 * dx)))
    y = line[i, 1] + f * (ay + f * (3 * dy - 2 * ay - by + f * (ay + by - 2 * dy)))
    tx = ax + f * (2 * (3 * dx - 2 * ax - bx) + 3 * f * (ax + bx - 2 * dx))
    ty = ay + f * (2 * (3 * dy - 2 * ay - by) + 3 * f * (ay + by - 2 * dy))
    norm = max(np.hypot(tx, ty), 1e-9)
    tx, ty = tx / norm, ty / norm
    curvature = (ax * by - ay * bx) / max(np.hypot(ax, ay) * np.hypot(bx, by), 1e-9) if beyond == 0 else 0.0
    return x + beyond * tx, y + beyond * ty, tx, ty, curvature


@njit(cache=True)
def carried_on(line: Doubles, s: float, axle: float) -> tuple[float, float, float, float, float, float]:
    """As `point_on`, of the middle of a vehicle with axles on `line`, `axle` [m] before and behind s, and how far it moves by s.

    The tangent is the direction that it heads in. The last number is 1 on a straight line and less in a bend.
    """
    if axle == 0:
        x, y, tx, ty, curvature = point_on(line, s)
        return x, y, tx, ty, curvature, 1.0
    ax, ay, a_tx, a_ty, a_curvature = point_on(line, s + axle)
    bx, by, b_tx, b_ty, b_curvature = point_on(line, s - axle)
    back = min(s - axle, 0.0)  # a line begins abreast of its vehicle: what it came by is taken for straight
    bx, by = bx + back * b_tx, by + back * b_ty
    tx, ty = ax - bx, ay - by
    length = max(np.hypot(tx, ty), 1e-9)
    pace = np.hypot(a_tx + b_tx, a_ty + b_ty) / 2
    return (ax + bx) / 2, (ay + by) / 2, tx / length, ty / length, (a_curvature + b_curvature) / 2, pace


@njit(cache=True)
def locate(line: Doubles, x: float, y: float, low: float, high: float) -> tuple[float, float]:
    """s and d [m] of the point (x, y), searched for between s = low and s = high."""
    first, last = max(int(low), 0), int(high) + 1
    best, squared = first, np.inf
    for p in range(first, last + 1):
        px, py = (line[p, 0], line[p, 1]) if p < len(line) else point_on(line, float(p))[:2]
        away = (px - x) ** 2 + (py - y) ** 2
        if away < squared:
            best, squared = p, away
    s, d = float(best), 0.0
    for _ in range(4):
        px, py, tx, ty, curvature = point_on(line, s)
        d = tx * (y - py) - ty * (x - px)
        s += (tx * (x - px) + ty * (y - py)) / max(1 - curvature * d, 0.2)
        s = min(max(s, best - 1.0, 0.0), best + 1.0)
    px, py, tx, ty, _ = point_on(line, s)
    return s, tx * (y - py) - ty * (x - px)


@njit(cache=True)
def located(line: Doubles, axle: float, x: float, y: float, low: float, high: float) -> tuple[float, float]:
    """As `locate`, with d from where `carried_on` has the vehicle."""
    s, d = locate(line, x, y, low, high)
    if axle > 0:
        px, py, tx, ty, _, _ = carried_on(line, s, axle)
        d = tx * (y - py) - ty * (x - px)
    return s, d


@njit(cache=True)
def _ends(table: Doubles, row: NDArray[np.int64], axle: Doubles, start: Doubles, goal: Doubles, window: Doubles) -> Doubles:
    """(B, 2, 5): s, d, heading, curvature and the last of `carried_on`, at the start and at the goal of each request."""
    out = np.empty((len(row), 2, 5))
    for b in range(len(row)):
        line = table[row[b]]
        for end in range(2):
            pose = start[b] if end == 0 else goal[b]
            low, high = (0.0, SEARCH) if end == 0 else (window[b, 0], window[b, 1])
            s, d = located(line, axle[b], pose[0], pose[1], low, high)
            _, _, tx, ty, curvature, pace = carried_on(line, s, axle[b])
            out[b, end, 0], out[b, end, 1], out[b, end, 2] = s, d, np.arctan2(ty, tx)
            out[b, end, 3], out[b, end, 4] = curvature, pace
    return out
