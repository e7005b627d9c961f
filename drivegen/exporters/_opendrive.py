"""A road map as OpenDRIVE 1.5: every lane is a road of its own with one lane to the right of its reference line; of a way
across that the map cuts in two both halves are one road.

The reference line is the lane's middle, a straight piece between every two points; the lane reaches from its left edge to its
right one, which are straight between places at most `EVERY` apart. Ways across a junction are connecting roads. A road is linked
to the one after it where it has one successor that has one predecessor; where lanes part or join outside a junction OpenDRIVE
has no link for roads, and none is written. A connecting road has one link at each end, so a way across with several lanes before
or after it is linked to the first of them.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from xml.etree.ElementTree import Element, indent, tostring

import numpy as np
from numpy.typing import NDArray
from scenariogeneration import xodr
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from drivegen.core.crop import take_lanes
from drivegen.core.geometry import Floats, Polylines, arc_length, interpolate, project
from drivegen.core.roadmap import LaneKind, RoadMap

_TYPES = {LaneKind.VEHICLE: xodr.LaneType.driving, LaneKind.BUS: xodr.LaneType.bus, LaneKind.BIKE: xodr.LaneType.biking}
_LANE = -1
"""OpenDRIVE's number of the only lane of each road."""

EVERY = 5.0
"""How far a lane's edges are is said at every point of its middle, and this often [m] ..."""

STEADY = 0.05
"""... but once for a lane whose edges stay this near [m] to their median."""


def opendrive(roads: RoadMap, name: str) -> bytes:
    """The map as an OpenDRIVE file, without a date; coordinates are the map's."""
    document, roads = xodr.OpenDrive(name), _in_one_piece(roads)
    junction = _junctions(roads)
    links = _Links(roads, junction)
    for lane in range(len(roads)):
        document.add_road(_road(roads, lane, int(junction[lane]), links))
    for number in range(int(junction.max()) + 1):
        document.add_junction(links.junction(number, len(roads) + number))
    root = document.get_element()
    for unknown in ("date", "north", "south", "east", "west"):
        root.find("header").attrib.pop(unknown, None)
    return serialised(root)


def serialised(root: Element) -> bytes:
    """An XML file, indented."""
    indent(root)
    return b'<?xml version="1.0" encoding="utf-8"?>\n' + bytes(tostring(root, encoding="utf-8")) + b"\n"


class _Links:
    """Which road follows which, and by which junction."""

    def __init__(self, roads: RoadMap, junction: NDArray[np.integer]) -> None:
        self._junction, self._count = junction, len(roads)
        self._pairs = [(int(a), int(b)) for a, b in roads.links]
        self._after, self._before = (Counter(pair[end] for pair in self._pairs) for end in (0, 1))

    def link(self, road: xodr.Road, own: xodr.Lane, lane: int) -> None:
        """Say what comes before and after the road of a lane, and its lane `own` where that is a road."""
        for a, b in self._pairs:
            inside = (int(self._junction[a]), int(self._junction[b]))
            if lane == a and road.successor is None:
                if self._single(a, b) or inside[0] >= 0:
                    road.add_successor(xodr.ElementType.road, b, xodr.ContactPoint.start)
                    own.add_link("successor", _LANE)
                elif inside[1] >= 0:
                    road.add_successor(xodr.ElementType.junction, self._count + inside[1])
            elif lane == b and road.predecessor is None:
                if self._single(a, b) or inside[1] >= 0:
                    road.add_predecessor(xodr.ElementType.road, a, xodr.ContactPoint.end)
                    own.add_link("predecessor", _LANE)
                elif inside[0] >= 0:
                    road.add_predecessor(xodr.ElementType.junction, self._count + inside[0])

    def junction(self, number: int, road_id: int) -> xodr.Junction:
        """A junction with the ways that lead into it."""
        element = xodr.Junction(f"junction {number}", road_id)
        for a, b in self._pairs:
            if self._junction[b] == number and self._junction[a] < 0:
                connection = xodr.Connection(a, b, xodr.ContactPoint.start)
                connection.add_lanelink(_LANE, _LANE)
                element.add_connection(connection)
        return element

    def _single(self, a: int, b: int) -> bool:
        return self._after[a] == self._before[b] == 1 and self._junction[a] < 0 and self._junction[b] < 0


def _in_one_piece(roads: RoadMap) -> RoadMap:
    """The map with ways across whole that it cuts in two, as SUMO does where one waits on the way: each road in a junction has
    to be entered from a road that leads there.
    """
    inside, pairs = roads.in_junction, [(int(a), int(b)) for a, b in roads.links]
    after, before = (Counter(pair[end] for pair in pairs) for end in (0, 1))
    halves = {a: b for a, b in pairs if inside[a] and inside[b] and after[a] == before[b] == 1 and a != b}
    whole = {head: [head] for head in sorted(halves.keys() - set(halves.values()))}
    for parts in whole.values():
        while parts[-1] in halves:
            parts.append(halves[parts[-1]])
    head_of = {parts[-1]: head for head, parts in whole.items()}
    later = {part for parts in whole.values() for part in parts[1:]}
    links = [(head_of.get(a, a), b) for a, b in pairs if b not in later]

    def joined(lines: Polylines) -> Polylines:
        parts = (whole.get(lane, [lane]) for lane in range(len(roads)))
        return Polylines.of([np.concatenate([lines[head], *(lines[part][1:] for part in rest)]) for head, *rest in parts])

    road_map = replace(
        roads,
        links=np.array(links, np.int32).reshape(-1, 2),
        centreline=joined(roads.centreline),
        left=joined(roads.left),
        right=joined(roads.right),
    )
    return take_lanes(road_map, np.array([lane for lane in range(len(roads)) if lane not in later]))


def _junctions(roads: RoadMap) -> NDArray[np.int64]:
    """(L,) the number of each lane's junction, -1 for none: ways across that begin or end at the same place are one junction's.

    A lane is two nodes, its beginning n and its end L + n; only ways across join theirs, so a lane between two junctions keeps
    them apart. OpenDRIVE has no junction without a road that leads in: ways that begin where the map is cut are roads.
    """
    count = len(roads)
    inside = roads.in_junction & np.isin(np.arange(count), roads.links[:, 1])
    ways, touches = np.flatnonzero(inside), roads.links[inside[roads.links].any(1)]
    end, beginning = np.concatenate([touches[:, 0] + count, ways + count]), np.concatenate([touches[:, 1], ways])
    near = coo_matrix((np.ones(len(end)), (end, beginning)), (2 * count, 2 * count))
    label = connected_components(near, directed=False)[1][:count]
    numbers = np.unique([label[b] for a, b in touches if not inside[a]])
    return np.where(inside & np.isin(label, numbers), np.searchsorted(numbers, label), -1)


def _road(roads: RoadMap, lane: int, junction: int, links: _Links) -> xodr.Road:
    section, lanes = xodr.LaneSection(0, xodr.Lane(xodr.LaneType.none)), xodr.Lanes()
    own = xodr.Lane(_TYPES[LaneKind(roads.kind[lane])])
    own.widths.clear()
    for along, (left, more_left), (width, wider) in _extents(roads, lane):
        own.add_lane_width(width, wider, soffset=along)
        lanes.add_laneoffset(xodr.LaneOffset(along, left, more_left))
    section.add_right_lane(own)
    lanes.add_lanesection(section)
    road_type = len(roads) + junction if junction >= 0 else -1
    road = xodr.Road(lane, _plan(roads.centreline[lane].astype(np.float64)), lanes, road_type, f"lane {roads.lane_id[lane]}")
    limit = float(roads.speed_limit[lane])
    road.add_type(xodr.RoadType.unknown, speed=None if np.isnan(limit) else round(limit, 3))
    road.add_elevation(0, 0, 0, 0, 0)
    links.link(road, own, lane)
    return road


def _plan(line: Floats) -> xodr.PlanView:
    plan = xodr.PlanView()
    for start, length, heading in _pieces(line):
        plan.add_fixed_geometry(xodr.Line(length), float(start[0]), float(start[1]), heading)
    plan.adjust_geometries()
    return plan


def _pieces(line: Floats) -> Iterator[tuple[Floats, float, float]]:
    for start, step in zip(line[:-1], np.diff(line, axis=0), strict=True):
        if (length := float(np.hypot(*step))) > 0:
            yield start, length, float(np.arctan2(step[1], step[0]))


def _extents(roads: RoadMap, lane: int) -> Iterator[tuple[float, tuple[float, float], tuple[float, float]]]:
    """From where along the lane [m], how far its left edge is from its middle, and its width [m], each with its growth per metre.

    Distances are of points of the middle from the edges, however few points these have.
    """
    middle, left, right = (lines[lane].astype(np.float64) for lines in (roads.centreline, roads.left, roads.right))
    points = arc_length(middle)
    along = np.unique(np.concatenate([points, np.arange(0.0, points[-1], EVERY)]).round(3))  # as exact as the file
    at = interpolate(middle, along)
    apart = np.array([[abs(project(edge, point)[1]) for point in at] for edge in (left, right)]).round(3)
    median = np.median(apart, axis=1).round(3)
    if (np.abs(apart - median[:, None]) <= STEADY).all():
        along, apart = along[[0, -1]], np.stack([median, median], 1)
    extents = np.stack([apart[0], apart.sum(0)], 1)
    growing = np.diff(extents, axis=0) / np.diff(along)[:, None]
    for place, (offset, width), (more, wider) in zip(along, extents, growing.round(6), strict=False):
        yield round(float(place), 3), (float(offset), float(more)), (round(float(width), 3), float(wider))
