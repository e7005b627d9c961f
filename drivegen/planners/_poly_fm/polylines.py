"""The map around a request as vectors: the pieces of lane nearest to its way, as numbers in the vehicle's frame.

Lanes are cut into pieces of POINTS points, SPACING apart, once per scenario; a request is told the MOST pieces that lie
nearest to the straight line from its start to its goal, each point in the frame of the start and in that of the goal.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import arc_length
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import Scenario
from drivegen.planners.base import PlanRequests

POINTS = 6
"""Points of a piece."""

SPACING = 4.0
"""Distance between them [m]."""

MOST = 32
"""Pieces that a request is told of."""

SCALE = 30.0
"""Coordinates are told in units of this [m], bent to stay within one (tanh)."""

PIECE = 4 * POINTS + 5
"""Numbers of a piece: points in both frames, limit, whether it is known, in a junction, distance, whether it is there."""


def surroundings(scenarios: Sequence[Scenario], requests: PlanRequests) -> NDArray[np.float32]:
    """(B, MOST * PIECE) float32, nearest first; pieces that are not there are zero."""
    out = np.zeros((len(requests), MOST, PIECE), np.float32)
    ends = [
        np.column_stack([position, heading]).astype(np.float64)
        for position, heading in ((requests.position, requests.heading), (requests.goal_position, requests.goal_heading))
    ]
    order = np.argsort(requests.scenario, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(requests.scenario[order])) + 1):
        if len(rows):
            line, about = _pieces(scenarios[requests.scenario[rows[0]]].map)
            out[rows] = _numbers(line, about, ends[0][rows], ends[1][rows])
    return out.reshape(len(requests), MOST * PIECE)


def _pieces(map_: RoadMap) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (Q, POINTS, 2) of all pieces of vehicle lanes, and (Q, 3) limit / 20, whether it is known, in a junction."""
    lines, about = [np.zeros((0, POINTS, 2))], [np.zeros((0, 3))]
    length = (POINTS - 1) * SPACING
    for lane in np.flatnonzero(map_.for_vehicles).tolist():
        line = map_.centreline[lane].astype(np.float64)
        s = arc_length(line)
        count = max(1, round(s[-1] / length))
        at = (np.arange(count)[:, None] + np.linspace(0, 1, POINTS)) * (s[-1] / count)
        lines.append(np.stack([np.interp(at, s, line[:, 0]), np.interp(at, s, line[:, 1])], axis=-1))
        limit = map_.speed_limit[lane]
        row = [np.nan_to_num(limit) / 20, np.isfinite(limit), map_.in_junction[lane]]
        about.append(np.tile(np.array(row, np.float64), (count, 1)))
    return np.concatenate(lines), np.concatenate(about)


@njit(cache=True)
def _numbers(
    line: NDArray[np.float64], about: NDArray[np.float64], start: NDArray[np.float64], goal: NDArray[np.float64]
) -> NDArray[np.float32]:
    """(B, MOST, PIECE) for requests from `start` (B, 3) to `goal` (B, 3), poses."""
    out = np.zeros((len(start), MOST, PIECE), np.float32)
    for b in range(len(start)):
        ax, ay = start[b, 0], start[b, 1]
        dx, dy = goal[b, 0] - ax, goal[b, 1] - ay
        squared = max(dx * dx + dy * dy, 1e-6)
        away = np.empty(len(line))
        for q in range(len(line)):
            nearest = np.inf
            for p in range(POINTS):
                x, y = line[q, p, 0] - ax, line[q, p, 1] - ay
                part = min(max((x * dx + y * dy) / squared, 0.0), 1.0)
                nearest = min(nearest, np.hypot(x - part * dx, y - part * dy))
            away[q] = nearest
        order = np.argsort(away, kind="mergesort")
        for m in range(min(MOST, len(order))):
            q = order[m]
            for end in range(2):
                pose = start[b] if end == 0 else goal[b]
                cos, sin = np.cos(pose[2]), np.sin(pose[2])
                for p in range(POINTS):
                    x, y = line[q, p, 0] - pose[0], line[q, p, 1] - pose[1]
                    column = 2 * (end * POINTS + p)
                    out[b, m, column] = np.tanh((cos * x + sin * y) / SCALE)
                    out[b, m, column + 1] = np.tanh((cos * y - sin * x) / SCALE)
            out[b, m, 4 * POINTS : 4 * POINTS + 3] = about[q]
            out[b, m, 4 * POINTS + 3] = away[q] / SCALE
            out[b, m, 4 * POINTS + 4] = 1.0
    return out
