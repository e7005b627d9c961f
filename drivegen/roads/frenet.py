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
    s, d = np.asarray(s, np.float64), np.asarray(d, np.float64)
    position, heading = _from_frenet(s.ravel(), d.ravel(), route.line, route.heading, SPACING)
    return position.reshape(*s.shape, 2), heading.reshape(s.shape)


def to_frenet(route: Route, points: Floats) -> NDArray[np.float32]:
    """s, d (Q, 2) [m] of points (Q, 2), each on its own (the nearest place on the line)."""
    result: NDArray[np.float32] = _to_frenet(np.ascontiguousarray(points, np.float64), route.line, route.heading, SPACING)
    return result


@njit(cache=True)
def _from_frenet(s, d, line, heading, spacing):  # type: ignore[no-untyped-def]
    last = len(line) - 1
    position, angle = np.empty((len(s), 2), np.float32), np.empty(len(s), np.float32)
    for q in range(len(s)):
        at = min(max(s[q] / spacing, 0.0), float(last))
        k = min(int(at), last - 1)
        share, beyond = at - k, s[q] - at * spacing
        turned = heading[k] + share * (heading[k + 1] - heading[k])
        cos, sin = np.cos(turned), np.sin(turned)
        x = line[k, 0] + share * (line[k + 1, 0] - line[k, 0])
        y = line[k, 1] + share * (line[k + 1, 1] - line[k, 1])
        position[q, 0], position[q, 1] = x + beyond * cos - d[q] * sin, y + beyond * sin + d[q] * cos
        angle[q] = turned
    return position, angle


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
