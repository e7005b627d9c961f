"""Cut surroundings of points out of a large road map; lanes stay whole, ends whose links cross the cut become cut ends."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, Polylines
from drivegen.core.roadmap import NO_LANE, RoadMap

_SPACING = 10.0
"""Lines are tested at points this far apart [m]: an edge of the cut is uncertain by half of it."""


class Cropper:
    """Prepares one large map so that many windows can be cut out of it, each in well under a millisecond per 1000 lanes."""

    def __init__(self, road_map: RoadMap) -> None:
        self._map = road_map
        self._lanes = _Samples(road_map.centreline, closed=False)
        self._drivable = _Samples(road_map.drivable, closed=True)
        self._crossings = _Samples(road_map.crossings, closed=True)

    def around(self, points: Floats, radius: Floats | float) -> tuple[RoadMap, NDArray[np.int64]]:
        """The part of the map within `radius` [m], one for all or (P,), of `points` (P, 2), same frame, and the kept lanes.

        The map has no lanes where none is that near.
        """
        radii = np.broadcast_to(np.asarray(radius), len(points))
        lanes = np.flatnonzero(self._lanes.near(points, radii))
        cut = take_lanes(self._map, lanes)
        drivable = np.flatnonzero(self._drivable.near(points, radii))
        crossings = np.flatnonzero(self._crossings.near(points, radii))
        return replace(cut, drivable=self._map.drivable.take(drivable), crossings=self._map.crossings.take(crossings)), lanes


def reach(speed: Floats, seconds: float, room: float) -> NDArray[np.float64]:
    """How far (N,) [m] around a vehicle of `speed` (N,) [m/s] the map goes: what it drives so in that time, and `room` more.

    It is of the first frame alone, so where a map ends tells nothing of who went where. In 10 s a car that stands and pulls
    away at 3 m/s2 up to 12 m/s gets 96 m far.
    """
    return np.asarray(room + np.abs(speed) * seconds, np.float64)


def take_lanes(road_map: RoadMap, lanes: NDArray[np.int64]) -> RoadMap:
    """The map with the lanes `lanes` (K,) only, in that order; drivable area and crossings stay as they are."""
    number = np.full(len(road_map) + 1, NO_LANE, np.int32)  # the last entry answers for NO_LANE
    number[lanes] = np.arange(len(lanes), dtype=np.int32)
    links, yields_to = number[road_map.links], number[road_map.yields_to]
    inside = (links != NO_LANE).all(-1)
    links, yields_to = links[inside], yields_to[(yields_to != NO_LANE).all(-1)]
    neighbour = number[road_map.neighbour[lanes]]
    stops = number[road_map.stop_lane] != NO_LANE
    return replace(
        road_map,
        lane_id=road_map.lane_id[lanes],
        kind=road_map.kind[lanes],
        centreline=road_map.centreline.take(lanes),
        left=road_map.left.take(lanes),
        right=road_map.right.take(lanes),
        speed_limit=road_map.speed_limit[lanes],
        in_junction=road_map.in_junction[lanes],
        control=road_map.control[lanes],
        links=links[np.lexsort(links.T[::-1])],
        neighbour=neighbour,
        same_direction=road_map.same_direction[lanes] & (neighbour != NO_LANE),
        may_change=road_map.may_change[lanes] & (neighbour != NO_LANE),
        cut=(road_map.cut | _severed(road_map.links, number))[lanes],
        stop_lines=road_map.stop_lines[stops],
        stop_lane=number[road_map.stop_lane[stops]],
        dangling=road_map.dangling + int((number[road_map.links] != NO_LANE).any(-1).sum() - inside.sum()),
        yields_to=yields_to[np.lexsort(yields_to.T[::-1])],
    )


def _severed(links: NDArray[np.int32], number: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(L, 2) lane starts and ends that lose a link (E, 2) because its other lane has no new `number` (L + 1,)."""
    severed = np.zeros((len(number) - 1, 2), np.bool_)
    before, after = links.T
    severed[after[number[before] == NO_LANE], 0] = True
    severed[before[number[after] == NO_LANE], 1] = True
    return severed


class _Samples:
    """Points along many lines, and which line each belongs to; of `closed` ones also from the last point to the first."""

    def __init__(self, lines: Polylines, *, closed: bool) -> None:
        step = np.diff(lines.points, axis=0, append=lines.points[-1:])
        last = lines.start[1:] - 1
        step[last] = lines.points[lines.start[:-1]] - lines.points[last] if closed else 0.0
        count = np.maximum(1, np.ceil(np.hypot(step[:, 0], step[:, 1]) / _SPACING)).astype(np.int64)
        row = np.repeat(np.arange(len(step)), count)
        along = (np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)) / count[row]
        self._points = lines.points[row] + step[row] * along[:, None].astype(np.float32)
        self._line = np.repeat(np.arange(len(lines)), np.diff(lines.start))[row]
        self._lines = len(lines)

    def near(self, points: Floats, radius: Floats) -> NDArray[np.bool_]:
        """(L,) whether the line comes within its `radius` (P,) [m] of any of `points` (P, 2)."""
        near = np.zeros(self._lines, np.bool_)
        for point, far in zip(points, radius, strict=True):
            gap = self._points - point
            near[self._line[(gap**2).sum(-1) <= far**2]] = True
        return near
