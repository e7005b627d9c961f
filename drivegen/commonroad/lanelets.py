"""CommonRoad's lanelets as the road map. A lanelet is a left and a right bound, both in driving direction.

Pavements are no lanes, nor are shoulders, borders, parking and restricted ones, which stay drivable; crosswalks become
pedestrian crossings. 2018b does not say where a junction is: there, the lanelets that cross another one, and those that
fork from or merge with such a one, count as in a junction.
"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element  # the type only: parsing is safe_xml's

import numpy as np
from numpy.typing import NDArray

from drivegen.commonroad import junctions, rules
from drivegen.commonroad.values import Points, identity, points, possible_limit, references, refuse, value
from drivegen.core.errors import naming
from drivegen.core.geometry import Polylines, arc_length, distinct, interpolate
from drivegen.core.recorded_log import FARTHEST
from drivegen.core.roadmap import NO_LANE, LaneKind, RoadMap, open_ends

KINDS = {"busLane": LaneKind.BUS, "bicycleLane": LaneKind.BIKE}
"""Lanelet types that are lanes for some only; all others but those below are for all vehicles."""

NO_LANES = ("sidewalk", "crosswalk", "shoulder", "border", "parking", "restricted")

_ONLY_FOR = {
    "bus": "busLane", "taxi": "busLane", "bicycle": "bicycleLane", "pedestrian": "sidewalk", "train": "restricted"
}  # fmt: skip
"""What a lanelet is whose named users are all among these, by the first that is named."""

MOST_LANES = 5000
"""A file with more lanes is refused: all pairs of them are compared."""

_SOLID = ("solid", "broad_solid")
_SPACING = 2.0
"""Points of a centreline lie about so far apart [m] where the bounds' points are no pairs."""


@dataclass(frozen=True)
class Lanelet:
    """One lanelet as the file has it; `types` may be empty.

    Attributes:
        left, right: (P, 2), (Q, 2) float64 [m], P, Q >= 2, no point repeated.
        beside: to the left and right: id and whether it runs the same way, or None.
        solid: whether the left and the right bound may not be crossed.
    """

    name: int
    left: Points
    right: Points
    types: frozenset[str]
    before: tuple[int, ...]
    after: tuple[int, ...]
    beside: tuple[tuple[int, bool] | None, tuple[int, bool] | None]
    solid: tuple[bool, bool]
    speed_limit: float
    element: Element

    @property
    def kind(self) -> LaneKind:
        """Who may use it."""
        return next((kind for word, kind in KINDS.items() if word in self.types), LaneKind.VEHICLE)


def read_map(root: Element, place: str) -> tuple[RoadMap, rules.Lights]:
    """The map in a frame at its middle, rounded to metres, and the lights that guard its lanes.

    Raises UnusableInput where there is no lane, or one without two bounds of two points each.
    """
    lanelets = [_read(element, place) for element in root.iterfind("lanelet")]
    lanes = [one for one in lanelets if not one.types.intersection(NO_LANES)]
    if not lanes:
        refuse(f"{place} has no lane", "no-lanes")
    if len(lanes) > MOST_LANES:
        refuse(f"{place} has {len(lanes)} lanes, more than {MOST_LANES}", "too-large")
    index = {one.name: i for i, one in enumerate(lanes)}
    bounds = np.concatenate([side for one in lanelets for side in (one.left, one.right)])
    origin = np.round((bounds.min(0) + bounds.max(0)) / 2)
    if np.abs(bounds - origin).max() > FARTHEST:
        refuse(f"{place} has lanelets more than {FARTHEST / 1000:g} km apart", "out-of-range")
    centreline = Polylines.of([_middle(one, place) - origin for one in lanes])
    links, dangling = _links(lanes, index, {one.name for one in lanelets})
    neighbour, same, may_change = _neighbours(lanes, index)
    inside = junctions.named(root, lanes, index, place)
    ruled = rules.read(root, [one.element for one in lanes], links, index, place)
    speed = np.array([one.speed_limit for one in lanes], np.float32)
    road_map = RoadMap(
        origin=origin,
        lane_id=np.array([one.name for one in lanes], np.int64),
        kind=np.array([one.kind for one in lanes], np.uint8),
        centreline=centreline,
        left=Polylines.of([one.left - origin for one in lanes]),
        right=Polylines.of([one.right - origin for one in lanes]),
        speed_limit=np.where(np.isnan(speed), ruled.speed_limit, speed).astype(np.float32),
        in_junction=junctions.crossing(centreline, links) if inside is None else inside,
        control=ruled.control,
        links=links,
        neighbour=neighbour,
        same_direction=same,
        may_change=may_change,
        cut=open_ends(links, len(lanes)),  # recordings show a stretch of road
        drivable=Polylines.of([_outline(one) - origin for one in lanelets if _is_road(one)]),
        crossings=Polylines.of([_corners(one) - origin for one in lanelets if "crosswalk" in one.types]),
        stop_lines=(ruled.stop_lines - origin).astype(np.float32),
        stop_lane=ruled.stop_lane,
        dangling=dangling,
    )
    with naming(place):
        road_map.validate()
    return road_map, ruled.lights


def _read(element: Element, place: str) -> Lanelet:
    name = identity(element, "id", place)
    place = f"{place}: lanelet {name}"
    bounds = [_bound(element, word, place) for word in ("leftBound", "rightBound")]
    limit = value(element, "speedLimit", place)
    return Lanelet(
        name=name,
        left=bounds[0],
        right=bounds[1],
        types=_types(element),
        before=tuple(references(element, "predecessor", place)),
        after=tuple(references(element, "successor", place)),
        beside=(_beside(element, "adjacentLeft", place), _beside(element, "adjacentRight", place)),
        solid=(_is_solid(element, "leftBound"), _is_solid(element, "rightBound")),
        speed_limit=float("nan") if limit is None else possible_limit(limit, place),
        element=element,
    )


def _types(element: Element) -> frozenset[str]:
    """Its own types, and what its users make of it."""
    types, one_way, both_ways = (_texts(element, word) for word in ("laneletType", "userOneWay", "userBidirectional"))
    users = one_way | both_ways
    if users and users <= _ONLY_FOR.keys():
        types.add(next(kind for user, kind in _ONLY_FOR.items() if user in users))
    return frozenset(types)


def _texts(element: Element, word: str) -> set[str]:
    return {(found.text or "").strip() for found in element.iterfind(word)}


def _bound(element: Element, word: str, place: str) -> Points:
    line = distinct(points(element.find(word), place)).astype(np.float64)
    if len(line) < 2:
        refuse(f"{place} has no <{word}> of two points or more", "bad-map")
    return line


def _is_solid(element: Element, word: str) -> bool:
    return element.findtext(f"{word}/lineMarking", "").strip() in _SOLID


def _beside(element: Element, word: str, place: str) -> tuple[int, bool] | None:
    neighbour = element.find(word)
    return None if neighbour is None else (identity(neighbour, "ref", place), neighbour.get("drivingDir") == "same")


def _middle(lane: Lanelet, place: str) -> Points:
    """Midway between the bounds: between their paired points, or, where they differ in number, at equal shares of both."""
    left, right = lane.left, lane.right
    if len(left) != len(right):
        along_left, along_right = (float(arc_length(side)[-1]) for side in (left, right))
        shares = np.linspace(0, 1, max(2, int(np.ceil(max(along_left, along_right) / _SPACING)) + 1))
        middle = (interpolate(left, shares * along_left) + interpolate(right, shares * along_right)) / 2
    else:
        middle = (left + right) / 2
    line = distinct(middle).astype(np.float64)
    if len(line) < 2:
        refuse(f"{place}: lanelet {lane.name} has no length between its bounds", "bad-map")
    return line


def _links(lanes: list[Lanelet], index: dict[int, int], names: set[int]) -> tuple[NDArray[np.int32], int]:
    """Links (E, 2), and how many name a lanelet that the file does not hold."""
    named = [(one.name, other) for one in lanes for other in one.after]
    named += [(other, one.name) for one in lanes for other in one.before]
    held = sorted({(index[a], index[b]) for a, b in named if a in index and b in index})
    missing = {(a, b) for a, b in named if not (a in names and b in names)}
    return np.array(held, np.int32).reshape(-1, 2), len(missing)


def _neighbours(lanes: list[Lanelet], index: dict[int, int]) -> tuple[NDArray[np.int32], NDArray[np.bool_], NDArray[np.bool_]]:
    """Neighbour (L, 2), same direction (L, 2) and may change (L, 2), columns left and right."""
    neighbour = np.full((len(lanes), 2), NO_LANE, np.int32)
    same, may_change = np.zeros((2, len(lanes), 2), np.bool_)
    for i, one in enumerate(lanes):
        for side, beside in enumerate(one.beside):
            if beside is not None and beside[0] in index:
                j = neighbour[i, side] = index[beside[0]]
                same[i, side] = beside[1]
                alike = (lanes[j].kind == LaneKind.BIKE) == (one.kind == LaneKind.BIKE)
                may_change[i, side] = beside[1] and not one.solid[side] and alike
    return neighbour, same, may_change


def _is_road(lane: Lanelet) -> bool:
    return not lane.types.intersection(("sidewalk", "crosswalk", "bicycleLane"))


def _outline(lane: Lanelet) -> Points:
    return np.concatenate([lane.right, lane.left[::-1]])


def _corners(lane: Lanelet) -> Points:
    """A crosswalk's corners (4, 2)."""
    return np.stack([lane.right[0], lane.right[-1], lane.left[-1], lane.left[0]])
