"""Where vehicles can stand on a map: points along the lanes, how fast one may go there, and how far lanes lie apart."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import arc_length, interpolate, line_heading
from drivegen.core.roadmap import LaneControl, LaneKind, RoadMap
from drivegen.placement.ways import Ways, limits, to_junction, turns

SPACING = 2.0
"""Distance between slots along a lane [m]."""

FAR = 400.0
"""Road ahead is not followed farther than this [m]."""

_BRAKING = 2.0
"""Comfortable deceleration [m/s2] before bends and stop lines."""

_LATERAL = 2.5
"""Lateral acceleration [m/s2] that drivers accept in bends."""

_BEND = 4.0
"""Turns are taken over so much of the way [m], or over the pieces of a line that are longer."""

_YIELD_SPEED = 5.0
"""Speed [m/s] at which one can still give way."""


def _road_from_start(links: NDArray[np.int32], length: NDArray[np.float64]) -> NDArray[np.float64]:
    """(L,) [m] of the longest way from the start of each lane, followed until it exceeds FAR by the lane's own length."""
    road = length.copy()
    before, after = links.reshape(-1, 2).T
    for _ in range(len(length)):
        longer = length.copy()
        np.maximum.at(longer, before, length[before] + np.minimum(road[after], FAR))
        if np.array_equal(longer, road):
            break
        road = longer
    return road


class Slots:
    """Q slots on the lanes of one map, made once and used for many scenes.

    Attributes:
        map: the map.
        lane: (Q,) int32. along: (Q,) float32 [m] from the lane's start. position: (Q, 2). heading: (Q,).
        limit: (Q,) float32 [m/s] speed from which one can still keep the limits, bends and stop lines ahead.
        road_ahead: (Q,) float64 [m] of lanes that can be driven from here without changing lanes, FAR at most.
        to_junction: (Q,) [m] along the lanes to where a junction begins; inf where none does near.
        lane_limit: (Q,) [m/s] the lane's speed limit.
        ways: driving distances between lanes. length: (L,) [m] of each lane. width: (L,) [m] the narrower end of each lane.
    """

    def __init__(self, road_map: RoadMap) -> None:
        self.map = road_map
        lines = [road_map.centreline[i].astype(np.float64) for i in range(len(road_map))]
        self.ways = Ways(road_map)
        self.length = self.ways.length
        self.width = np.array([_width(road_map, i) for i in range(len(road_map))])
        profiles = _Profiles(road_map, lines, self.length, self.ways.onward)
        usable = np.flatnonzero((road_map.kind != LaneKind.BIKE) & ~road_map.in_junction & (self.length > SPACING))
        places = [(lane, np.arange(SPACING / 2, self.length[lane], SPACING)) for lane in usable.tolist()]
        self.lane = np.concatenate([np.full(len(at), lane, np.int32) for lane, at in places] or [np.zeros(0, np.int32)])
        self.along = np.concatenate([at for _, at in places] or [np.zeros(0)])
        self.position = np.concatenate([interpolate(lines[lane], at) for lane, at in places] or [np.zeros((0, 2))])
        self.heading = np.concatenate([_headings(lines[lane], at) for lane, at in places] or [np.zeros(0)])
        self.limit = np.concatenate([profiles.speed(lane, at) for lane, at in places] or [np.zeros(0)])
        self.road_ahead = np.minimum((_road_from_start(road_map.links, self.length))[self.lane] - self.along, FAR)
        self.lane_limit = limits(road_map)[self.lane]
        self.to_junction = to_junction(road_map, self.ways)[self.lane] + self.length[self.lane] - self.along

    def __len__(self) -> int:
        return len(self.lane)

    @cached_property
    def to_turn(self) -> NDArray[np.float64]:
        """(Q, 3) [m] to the junction through which the lane leads as each member of `Turn` says; inf where it does not."""
        return np.where(turns(self.map, self.ways)[self.lane], (self.length[self.lane] - self.along)[:, None], np.inf)

    def limit_before(self, closed: NDArray[np.int32]) -> NDArray[np.float64]:
        """`limit` (Q,) where the lanes `closed` (C,) must not be entered now, as behind a red light."""
        entry = np.full(len(self.length), np.inf)
        entry[closed] = 0.0
        end = _end_speeds(entry, self.length, self.ways.onward)[self.lane]
        return np.asarray(np.minimum(self.limit, np.sqrt(end**2 + 2 * _BRAKING * (self.length[self.lane] - self.along))))


def _end_speeds(entry: NDArray[np.float64], length: NDArray[np.float64], onward: dict[int, list[int]]) -> NDArray[np.float64]:
    """(L,) [m/s] at each lane's end, from which one can still slow down to `entry` (L,) of all lanes of the fastest way on.

    Lanes across a junction are short: what follows them has to be seen from before it.
    """
    start, end = entry, entry
    for _ in range(len(entry)):
        end = np.array([max((start[after] for after in onward.get(lane, [])), default=entry[lane]) for lane in range(len(entry))])
        slower = np.minimum(entry, np.sqrt(end**2 + 2 * _BRAKING * length))
        if np.array_equal(slower, start):
            break
        start = slower
    return end


def _width(road_map: RoadMap, lane: int) -> float:
    left, right = road_map.left[lane], road_map.right[lane]
    return float(min(np.hypot(*(left[0] - right[0])), np.hypot(*(left[-1] - right[-1]))))


def _headings(line: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    segment = np.clip(np.searchsorted(arc_length(line), at, side="right") - 1, 0, len(line) - 2)
    return np.asarray(line_heading(line)[segment])


class _Profiles:
    """Speeds along lanes from which the driver can still slow down for what follows."""

    def __init__(
        self, road_map: RoadMap, lines: list[NDArray[np.float64]], length: NDArray[np.float64], onward: dict[int, list[int]]
    ) -> None:
        self._cap = np.minimum(limits(road_map), [_bend_speed(line) for line in lines])
        self._length = length
        entry = np.where(road_map.control == LaneControl.YIELD, np.minimum(self._cap, _YIELD_SPEED), self._cap)
        entry = np.where(road_map.control == LaneControl.STOP, 0.0, entry)
        self._end = _end_speeds(entry, length, onward)

    def speed(self, lane: int, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K,) [m/s] at `at` (K,) [m] along the lane."""
        braking = np.sqrt(self._end[lane] ** 2 + 2 * _BRAKING * (self._length[lane] - at))
        return np.asarray(np.minimum(self._cap[lane], braking))


def _bend_speed(line: NDArray[np.float64]) -> float:
    """Speed [m/s] at the sharpest bend of the line: lateral acceleration over the turn within _BEND of each vertex."""
    step = np.diff(line, axis=0)
    if len(step) < 2:
        return float("inf")
    heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    size = np.hypot(step[:, 0], step[:, 1])
    at, turned = np.cumsum(size)[:-1], np.concatenate([[0.0], np.cumsum(np.diff(heading))])
    last, first = np.searchsorted(at, at + _BEND / 2, "right"), np.searchsorted(at, at - _BEND / 2, "left")
    sharpest = float((np.abs(turned[last] - turned[first]) / np.maximum((size[1:] + size[:-1]) / 2, _BEND)).max())
    return float(np.sqrt(_LATERAL / max(sharpest, 1e-4)))
