"""What route_fm's network is told about a request: numbers of order one, the road ahead at fixed parts of the way."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.planners.base import ROUTE_SPACING, PlanRequests
from drivegen.planners.shared.paths import Doubles, Frames, point_on

STATIONS = 16
"""Places between start and goal at which curvature and speed limit are told."""

FEATURES = 28 + 2 * STATIONS
"""F, the width of the network's input."""


def features(frames: Frames, requests: PlanRequests) -> NDArray[np.float32]:
    """(B, F) float32; whatever is unknown or absent is zero, with a flag that says so."""
    distance, duration, speed = frames.distance, frames.duration, frames.speed
    mean = distance / duration
    lead, stop = _nearness(requests.leader_gap), _nearness(requests.stop_s)
    has_leader, has_stop = np.isfinite(requests.leader_gap), np.isfinite(requests.stop_s)
    gap = np.where(has_leader, requests.leader_gap, 0.0)
    until_stop = np.where(has_stop, requests.stop_s, 0.0)
    curvature = _curvature(frames.table, frames.row, frames.start, distance)
    limit = _limits(frames, requests)
    columns = [
        speed[:, 0] / 10,
        speed[:, 1] / 10,
        mean / 10,
        distance / 50,
        np.log1p(distance) / 3,
        duration / 10,
        (speed[:, 0] - mean) / 5,
        (speed[:, 1] - mean) / 5,
        speed[:, 0] / (speed.sum(axis=1) + 1),
        np.exp(-speed[:, 0]),
        np.exp(-speed[:, 1]),
        np.tanh(speed[:, 0] * duration / (distance + 1) / 4),
        np.tanh(speed[:, 1] * duration / (distance + 1) / 4),
        frames.offset[:, 0] / 2,
        frames.offset[:, 1] / 2,
        np.clip(frames.turn[:, 0], -1, 1) * 3,
        np.clip(frames.turn[:, 1], -1, 1) * 3,
        requests.size[:, 0] / 5 - 1,
        requests.size[:, 1] / 2 - 1,
        requests.route >= 0,
        lead,
        has_leader,
        requests.leader_speed / 10,
        np.tanh((gap + requests.leader_speed * duration - distance) / 20) * has_leader,
        stop,
        has_stop,
        np.tanh((until_stop - distance) / 10) * has_stop,
        np.abs(curvature).max(axis=1) * 10,
        *(curvature * 10).T,
        *limit.T,
    ]
    return np.column_stack(columns).astype(np.float32)


def _nearness(distance: NDArray[np.float32]) -> NDArray[np.float32]:
    """1 at 0 m, a half at 10 m, 0 for infinity."""
    return 1.0 / (1.0 + distance / 10.0)


@njit(cache=True)
def _curvature(table: Doubles, row: NDArray[np.int64], start: Doubles, distance: Doubles) -> Doubles:
    """(B, STATIONS) [1/m]."""
    out = np.empty((len(row), STATIONS))
    for b in range(len(row)):
        for k in range(STATIONS):
            out[b, k] = point_on(table[row[b]], start[b] + distance[b] * (k + 0.5) / STATIONS)[4]
    return np.clip(out, -0.3, 0.3)


def _limits(frames: Frames, requests: PlanRequests) -> NDArray[np.float64]:
    """(B, STATIONS): by how much the speed limit exceeds the mean speed, in 10 m/s; 0 where there is none."""
    out = np.zeros((len(requests), STATIONS))
    on_route = requests.route >= 0
    if on_route.any():
        part = (np.arange(STATIONS) + 0.5) / STATIONS
        s = frames.start[on_route, None] + frames.distance[on_route, None] * part
        at = np.clip(s / ROUTE_SPACING, 0, requests.route_line.shape[1] - 1).astype(np.intp)
        limit = requests.route_speed_limit[requests.route[on_route][:, None], at]
        mean = (frames.distance / frames.duration)[on_route, None]
        out[on_route] = np.nan_to_num((limit - mean) / 10)
    return out
