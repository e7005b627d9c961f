"""Frenet coordinates on a route: s along its line, d to the left of it; off the line's ends the line goes straight on.

The line's normals are interpolated between its points, so `d` is smooth along a bend and the two directions are exact
inverses wherever |d| is less than the bend's radius.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.roads.line import SPACING, Route


def from_frenet(
    route: Route, s: NDArray[np.floating], d: NDArray[np.floating]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Positions (..., 2) [m] and the line's headings (...) [rad] at `s`, `d` (...) [m]."""
    last = len(route.line) - 1
    at = np.clip(np.asarray(s, np.float64) / SPACING, 0.0, last)
    first = np.minimum(at.astype(np.int64), last - 1)
    share = at - first
    heading = route.heading[first] + share * (route.heading[first + 1] - route.heading[first])
    forward = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    left = np.stack([-forward[..., 1], forward[..., 0]], axis=-1)
    on_line = route.line[first] + share[..., None] * (route.line[first + 1] - route.line[first])
    beyond = np.asarray(s, np.float64) - at * SPACING
    position = on_line + beyond[..., None] * forward + np.asarray(d, np.float64)[..., None] * left
    return position.astype(np.float32), heading.astype(np.float32)


def to_frenet(route: Route, points: Floats) -> NDArray[np.float32]:
    """s, d (Q, 2) [m] of points (Q, 2), each on its own (the nearest place on the line)."""
    result: NDArray[np.float32] = _to_frenet(np.ascontiguousarray(points, np.float64), route.line, route.heading, SPACING)
    return result


@njit(cache=True)
def _nearest_point(x, y, line):  # type: ignore[no-untyped-def]
    best, squared = 0, np.inf
    for k in range(len(line)):
        gap = (line[k, 0] - x) ** 2 + (line[k, 1] - y) ** 2
        if gap < squared:
            best, squared = k, gap
    return best


@njit(cache=True)
def _to_frenet(points, line, heading, spacing):  # type: ignore[no-untyped-def]
    """Newton steps on (p - line(s)) . forward(s) = 0 from the nearest point of the line."""
    last = len(line) - 1
    result = np.empty((len(points), 2), np.float32)
    for q in range(len(points)):
        x, y = points[q]
        at = float(_nearest_point(x, y, line))
        cos, sin, gap_x, gap_y = 1.0, 0.0, 0.0, 0.0
        for _ in range(12):
            inside = min(max(at, 0.0), float(last))
            k = min(int(inside), last - 1)
            share = inside - k
            angle = heading[k] + share * (heading[k + 1] - heading[k])
            cos, sin = np.cos(angle), np.sin(angle)
            off = (at - inside) * spacing
            gap_x = x - line[k, 0] - share * (line[k + 1, 0] - line[k, 0]) - off * cos
            gap_y = y - line[k, 1] - share * (line[k + 1, 1] - line[k, 1]) - off * sin
            along = gap_x * cos + gap_y * sin
            bend = (heading[k + 1] - heading[k]) / spacing if off == 0.0 else 0.0
            slope = max(1.0 - bend * (cos * gap_y - sin * gap_x), 0.2)
            at += min(max(along / slope / spacing, -1.0), 1.0)
            if abs(along) < 1e-5:
                break
        result[q, 0], result[q, 1] = at * spacing, cos * gap_y - sin * gap_x
    return result
