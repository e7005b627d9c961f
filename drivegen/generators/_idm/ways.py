"""The ways that vehicles may take from where they are at step 0, as tables of points a metre apart."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import project, unit
from drivegen.core.scenario import DT, Scenario
from drivegen.roads.graph import LaneGraph
from drivegen.roads.parked import parked
from drivegen.roads.reach import Dynamics, speed_caps
from drivegen.roads.routes import SPACING, feasible_routes

POINTS = 400
"""P, points of every way: 10 s at 40 m/s; ways go straight on beyond their lanes."""

CRUISE = 16.0
"""[m/s] Ways branch as far as this speed gets, or the vehicle's own plus what it gains ..."""

GAIN = 1.25
"""... by this factor."""

BLEND_SECONDS, BLEND_LEAST = 3.0, 15.0
"""[s], [m] A vehicle's offset from the way's line fades out over this."""

BENDS = Dynamics(acceleration=1.5, braking=2.0, lateral=2.5, limit_factor=1.5)
"""How fast a way's bends let anyone drive, whose wish is 1.5 times the limit at most, and how early he slows down for them."""


@dataclass(frozen=True)
class Ways:
    """W ways of a scenario's N vehicles; s = 0 is where the vehicle is.

    Attributes:
        start: (N + 1,) first way of each vehicle, and W; each has one at least.
        point: (W, P, 2) float32 [m], the vehicle's own offset faded out. limit: (W, P) float32 [m/s], NaN unknown.
        cap: (W, P) float32 [m/s] what bends allow, and comfortable braking for those ahead.
        lane: (W, P) int32 lane under each point, -1 where there is none.
        parked: (N,) bool vehicles that never move, by `roads.parked`.
    """

    start: NDArray[np.intp]
    point: NDArray[np.float32]
    limit: NDArray[np.float32]
    cap: NDArray[np.float32]
    lane: NDArray[np.int32]
    parked: NDArray[np.bool_]

    @classmethod
    def of(cls, scenario: Scenario, most: int, lane_changes: int) -> "Ways":
        """At most `most` ways of each vehicle with at most `lane_changes` lane changes."""
        graph, vehicles = LaneGraph.of(scenario.map), scenario.vehicles
        by_vehicle = [_of_vehicle(graph, scenario, n, most, lane_changes) for n in range(len(vehicles))]
        start = np.cumsum([0, *(len(ways) for ways in by_vehicle)])
        points, limits, caps, lanes = zip(*(way for ways in by_vehicle for way in ways), strict=True)
        return cls(start, np.stack(points), np.stack(limits), np.stack(caps), np.stack(lanes), parked(graph, vehicles))


_Way = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]


def _of_vehicle(graph: LaneGraph, scenario: Scenario, n: int, most: int, lane_changes: int) -> list[_Way]:
    vehicles = scenario.vehicles
    position, heading, speed = vehicles.position[n], float(vehicles.heading[n]), float(vehicles.speed[n])
    reach = min(max(CRUISE, GAIN * speed) * scenario.horizon * DT, (POINTS - 1) * SPACING)
    routes = feasible_routes(graph, position, heading, speed, reach, most, lane_changes, int(vehicles.kind[n]))
    ways = [
        _faded(route.line, route.speed_limit, speed_caps(route, speed, BENDS), route.lane, position, speed) for route in routes
    ]
    if ways:
        return ways
    line = position + unit(np.array(heading)) * np.arange(2)[:, None] * SPACING
    return [_faded(line, np.full(2, np.nan), np.full(2, np.inf), np.full(2, -1), position, speed)]


def _faded(
    line: NDArray[np.floating],
    limit: NDArray[np.floating],
    cap: NDArray[np.floating],
    lane: NDArray[np.integer],
    position: NDArray[np.float32],
    speed: float,
) -> _Way:
    """POINTS points from the vehicle on, its offset from the line faded out."""
    line = line.astype(np.float64)
    begin = min(max(round(project(line[: 1 + round(60 / SPACING)], position)[0] / SPACING), 0), len(line) - 2)
    line, limit, cap, lane = line[begin:], limit[begin:], cap[begin:], lane[begin:]
    missing = max(POINTS - len(line), 0)
    step = line[-1] - line[-2]
    line = np.concatenate([line, line[-1] + step * np.arange(1, missing + 1)[:, None]])[:POINTS]
    share = np.minimum(np.arange(POINTS) * SPACING / max(BLEND_LEAST, BLEND_SECONDS * speed), 1.0)[:, None]
    line = line + (position - line[0]) * (1 - share**2 * (3 - 2 * share))
    limit, cap, lane = (np.pad(a, (0, missing), mode="edge")[:POINTS] for a in (limit, cap, lane))
    return line.astype(np.float32), limit.astype(np.float32), cap.astype(np.float32), lane.astype(np.int32)
