"""How far lanes lie apart for somebody who drives from one to another, and what waits at their ends."""

import heapq
from collections import defaultdict
from collections.abc import Iterator, Mapping
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, arc_length, line_heading, wrap_angle
from drivegen.core.roadmap import RoadMap
from drivegen.core.signals import Signals, SignalState
from drivegen.roads.gates import first_crossing

CLOSED = (SignalState.RED, SignalState.YELLOW)
"""Nobody starts moving just before a signal that shows one of these."""

UNKNOWN_LIMIT = 13.9
"""Speed limit [m/s] assumed where the map has none: 50 km/h."""

REACH = 120.0
"""How far ahead vehicles matter to each other [m]."""


TURN = (np.deg2rad(50), np.deg2rad(130))
"""A way across a junction that changes direction by as much is a turn [rad]; more is a U-turn."""

CROSSES = np.deg2rad(30)
"""Ways that meet at a smaller angle [rad] merge or part; they do not cross."""


class Turn(StrEnum):
    """How a vehicle goes through a junction; STRAIGHT: over one at which other ways cross its own."""

    LEFT = "left"
    RIGHT = "right"
    STRAIGHT = "straight"


_Reached = tuple[NDArray[np.intp], NDArray[np.float64]]
"""Lanes (R,) and the [m] to each: those within REACH are few, so what is kept grows with the map and not with its square."""


class Ways:
    """Driving distances on one map, without lane changes.

    Attributes:
        length: (L,) [m] of each lane. onward, back: the lanes that follow and precede each lane.
    """

    def __init__(self, road_map: RoadMap) -> None:
        self.length = np.array([arc_length(road_map.centreline[i].astype(np.float64))[-1] for i in range(len(road_map))])
        self.onward: dict[int, list[int]] = defaultdict(list)
        self.back: dict[int, list[int]] = defaultdict(list)
        for before, after in road_map.links.tolist():
            self.onward[before].append(after)
            self.back[after].append(before)
        self._after: dict[int, _Reached] = {}
        self._before: dict[int, _Reached] = {}

    def ahead(self, lane: int, along: float, lanes: NDArray[np.int32], alongs: NDArray[np.floating]) -> NDArray[np.float64]:
        """Driving distance (K,) [m] from one place to others ahead of it; inf where there is none within REACH or so."""
        far = self._between(self._after, self.onward, lane)[lanes] + (self.length[lane] - along) + alongs
        return np.where((lanes == lane) & (alongs >= along), alongs - along, far)

    def behind(self, lane: int, along: float, lanes: NDArray[np.int32], alongs: NDArray[np.floating]) -> NDArray[np.float64]:
        """Driving distance (K,) [m] from other places to this one ahead of them; inf where there is none within REACH or so."""
        far = self._between(self._before, self.back, lane)[lanes] + (self.length[lanes] - alongs) + along
        return np.where((lanes == lane) & (alongs <= along), along - alongs, far)

    def _between(self, known: dict[int, _Reached], following: Mapping[int, list[int]], lane: int) -> Floats:
        """(L,) [m] of the lanes between `lane` and every other one, both left out, within REACH; inf beyond."""
        if lane not in known:
            known[lane] = self._search(following, lane)
        reached, metres = known[lane]
        distance = np.full(len(self.length), np.inf)
        distance[reached] = metres
        return distance

    def _search(self, following: Mapping[int, list[int]], lane: int) -> _Reached:
        """Those that are within REACH."""
        distance: dict[int, float] = {}
        heap = [(0.0, after) for after in following.get(lane, [])]
        while heap:
            so_far, here = heapq.heappop(heap)
            if here in distance or so_far > REACH:
                continue
            distance[here] = so_far
            for after in following.get(here, []):
                heapq.heappush(heap, (so_far + float(self.length[here]), after))
        return np.array(list(distance), np.intp), np.array(list(distance.values()), np.float64)


def limits(road_map: RoadMap) -> NDArray[np.float64]:
    """(L,) [m/s] speed limits, UNKNOWN_LIMIT where the map has none."""
    with_limit = np.isfinite(road_map.speed_limit)
    return np.where(with_limit, road_map.speed_limit, UNKNOWN_LIMIT).astype(np.float64)


def closed_lanes(signals: Signals) -> NDArray[np.int32]:
    """Lanes that must not be entered at the first step."""
    return np.asarray(signals.lane[np.isin(signals.state[:, 0], CLOSED)])


def blocked(ways: Ways, closed: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(L,) which lanes lead into none but `closed` ones (C,)."""
    shut = np.zeros(len(ways.length), np.bool_)
    shut[closed] = True
    onward = (ways.onward.get(lane, []) for lane in range(len(shut)))
    return np.array([bool(after) and bool(shut[after].all()) for after in onward], np.bool_)


def to_junction(road_map: RoadMap, ways: Ways) -> NDArray[np.float64]:
    """(L,) [m] from each lane's end to where a junction begins; inf where none does within REACH or so, and inside of one."""
    inside, distance = road_map.in_junction, np.full(len(road_map), np.inf)
    heap = [(0.0, before) for before, after in road_map.links.tolist() if inside[after] and not inside[before]]
    while heap:
        away, lane = heapq.heappop(heap)
        if away >= distance[lane] or away > REACH:
            continue
        distance[lane] = away
        for before in ways.back.get(lane, []):
            if not inside[before]:
                heapq.heappush(heap, (away + float(ways.length[lane]), before))
    return distance


def turns(road_map: RoadMap, ways: Ways) -> NDArray[np.bool_]:
    """(L, 3) whether each lane's end leads through a junction to the left, to the right, straight on: the members of `Turn`.

    A way round a ring is several junctions, none of them turned at: what leads round it is no turn.
    """
    leads = np.zeros((len(road_map), 3), np.bool_)
    (low, high), across = TURN, crossed(road_map)
    for lane in np.flatnonzero(~road_map.in_junction).tolist():
        arrives = line_heading(road_map.centreline[lane][-2:].astype(np.float64))[-1]
        for after, crosses in _beyond(road_map, ways, lane, across):
            leaves = line_heading(road_map.centreline[after][:2].astype(np.float64))[0]
            change = float(wrap_angle(np.asarray(leaves - arrives)))
            leads[lane] |= low < change < high, low < -change < high, crosses and abs(change) < low
    return leads


def _beyond(road_map: RoadMap, ways: Ways, lane: int, crossed: NDArray[np.bool_]) -> Iterator[tuple[int, bool]]:
    """Lanes that a junction at the lane's end leads to, and whether the way there is `crossed` (L,) by another."""
    inside, visited = (
        [(i, bool(crossed[i])) for i in ways.onward.get(lane, []) if road_map.in_junction[i]],
        set[tuple[int, bool]](),
    )
    while inside:
        here, crosses = inside.pop()
        if not road_map.in_junction[here]:
            yield here, crosses
        elif (here, crosses) not in visited:
            visited.add((here, crosses))
            inside += [(after, crosses or bool(crossed[after])) for after in ways.onward.get(here, [])]


def crossed(road_map: RoadMap) -> NDArray[np.bool_]:
    """(L,) whether each lane is a way over a junction that another crosses; none does where motorways merge or lose lanes."""
    inside = np.flatnonzero(road_map.in_junction & road_map.for_vehicles)
    line = road_map.centreline
    low, high = (np.array([edge(line[lane], axis=0) for lane in inside.tolist()]).reshape(-1, 2) for edge in (np.min, np.max))
    found = np.zeros(len(road_map), np.bool_)
    for k, lane in enumerate(inside.tolist()):
        near = k + 1 + np.flatnonzero(((low[k + 1 :] <= high[k]) & (low[k] <= high[k + 1 :])).all(-1))
        for other in inside[near].tolist():
            if not (found[lane] and found[other]) and _cross(road_map, lane, other):
                found[lane] = found[other] = True
    return found


def _cross(road_map: RoadMap, lane: int, other: int) -> bool:
    line, towards = road_map.centreline, []
    for a, b in ((lane, other), (other, lane)):
        meet, _, _, dx, dy = first_crossing(line.points, *line.start[[a, a + 1]], *line.start[[b, b + 1]])
        towards.append(np.arctan2(dy, dx))
    return bool(meet) and abs(float(wrap_angle(np.asarray(towards[0] - towards[1])))) > CROSSES
