"""What stands in the way on a route at the first frame: the next vehicle ahead, red lights, ways into junctions."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.core.roadmap import LaneControl, RoadMap
from drivegen.core.scenario import Scenario
from drivegen.roads.frenet import to_frenet
from drivegen.roads.line import SPACING, Route

IN_LANE = 1.4
"""A vehicle whose middle is this near to the line [m] is on the route."""

STAND = 1.0
"""Who stops at a line stands this far before it [m]."""

HALTED = 1.0
"""Who is slower than this [m/s] in a queue is taken to have halted: queues creep."""

SAME_WAY = np.pi / 3
"""A vehicle with a heading farther from the line's than this [rad] leads nobody."""

_HALF_TURN, _TURN, _FREE = np.float32(np.pi), np.float32(2 * np.pi), int(LaneControl.FREE)  # for compiled code


@dataclass(frozen=True)
class Ahead:
    """What a vehicle finds ahead on one route, as distances of its own centre [m]; inf where there is nothing.

    Attributes:
        leader_gap: bumper to bumper to the next vehicle ahead. leader_speed: [m/s] along the route, 0 without a leader.
        red_s: where its centre is when it stands at the next stop line that is red or yellow.
        entry_s: the same for the next way into a junction where it may have to wait.
    """

    leader_gap: float
    leader_speed: float
    red_s: float
    entry_s: float


@dataclass(frozen=True)
class Neighbours:
    """Everybody else at step 0: M vehicles and context actors that are there.

    Attributes:
        position: (M, 2). heading: (M,). speed: (M,). length: (M,).
    """

    position: Floats
    heading: Floats
    speed: Floats
    length: Floats

    @classmethod
    def of(cls, scenario: Scenario, vehicle: int) -> "Neighbours":
        """All but `vehicle`."""
        everybody = scenario.present()
        others = np.arange(len(everybody)) != vehicle
        return cls(everybody.position[others], everybody.heading[others], everybody.speed[others], everybody.size[others, 0])

    def near(self, position: Floats, radius: float) -> "Neighbours":
        """Those within `radius` [m]."""
        keep = np.hypot(*(self.position - position).T) <= radius
        return Neighbours(self.position[keep], self.heading[keep], self.speed[keep], self.length[keep])


@dataclass(frozen=True)
class Queue:
    """Everybody on a route ahead of a vehicle, nearest first.

    Attributes:
        s: (M,) float64 [m] middle along the route. speed: (M,) [m/s] along it, not negative. length: (M,) [m].
    """

    s: NDArray[np.float64]
    speed: NDArray[np.float64]
    length: NDArray[np.float64]

    @classmethod
    def on(cls, route: Route, neighbours: Neighbours) -> "Queue":
        """Those of `neighbours` that are within the lane and go the same way."""
        place = to_frenet(route, neighbours.position)
        there, turn = _followed(place, neighbours.heading, route.heading, np.float32(route.length))
        pace = np.maximum(neighbours.speed[there] * np.cos(turn), 0.0)
        return cls(*(a.astype(np.float64) for a in (place[there, 0], pace, neighbours.length[there])))


@njit(cache=True)
def _followed(place, heading, line_heading, length):  # type: ignore[no-untyped-def]
    """Who of M boxes at s, d (M, 2) is on the route and goes its way, nearest first, and how far each is turned from it [rad]."""
    there, turn = np.empty(len(place), np.int64), np.empty(len(place), np.float32)
    count = 0
    for m in range(len(place)):
        s, d = place[m]
        if not (s > 0 and abs(d) < np.float32(IN_LANE) and s < length):
            continue
        turned = abs((heading[m] - line_heading[int(s / np.float32(SPACING))] + _HALF_TURN) % _TURN - _HALF_TURN)
        if turned >= np.float32(SAME_WAY):
            continue
        k = count
        while k > 0 and place[there[k - 1], 0] > s:
            there[k], turn[k] = there[k - 1], turn[k - 1]
            k -= 1
        there[k], turn[k] = m, turned
        count += 1
    return there[:count], turn[:count]


def look_ahead(scenario: Scenario, route: Route, neighbours: Neighbours, length: float) -> Ahead:
    """What a vehicle of `length` [m] at s = 0 finds on `route`."""
    gap, speed = _leader(Queue.on(route, neighbours), length)
    front = length / 2 + STAND
    closed = scenario.signals.lane[scenario.signals.closed[:, 0]]
    return Ahead(gap, speed, _first_entry(route, closed) - front, _first_wait(route, scenario.map) - front)


def _leader(queue: Queue, length: float) -> tuple[float, float]:
    if len(queue.s) == 0:
        return np.inf, 0.0
    gap = queue.s - (queue.length + length) / 2
    first = int(np.argmin(gap))
    return max(float(gap[first]), 0.0), float(queue.speed[first])


def _first_entry(route: Route, lanes: NDArray[np.int32]) -> float:
    """Distance [m] to where the route enters the first of `lanes`; inf if it does not."""
    return float(_first_among(route.entries, route.lane, lanes))


@njit(cache=True)
def _first_among(entries, lane, lanes):  # type: ignore[no-untyped-def]
    for at in entries:
        for other in lanes:
            if lane[at] == other:
                return at * SPACING
    return np.inf


def _first_wait(route: Route, road_map: RoadMap) -> float:
    """Distance [m] to the first lane across a junction that is not known to be free; inf if there is none."""
    return float(_first_not_free(route.entries, route.lane, road_map.in_junction, road_map.control))


@njit(cache=True)
def _first_not_free(entries, lane, in_junction, control):  # type: ignore[no-untyped-def]
    for at in entries:
        entered, left = lane[at], lane[at - 1]
        if in_junction[entered] and not in_junction[left] and control[entered] != _FREE:
            return at * SPACING
    return np.inf
