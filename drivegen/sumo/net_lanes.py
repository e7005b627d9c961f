"""The lanes, crossings and junction surfaces of a SUMO network file, and which lanes lie side by side."""

from collections import Counter
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import LaneKind
from drivegen.sumo.strips import crossing_corners

Points = NDArray[np.float64]

DEFAULT_WIDTH = 3.2
"""Width of a lane that does not state one [m] (SUMO's default)."""

_ROAD_CLASSES = ("truck", "trailer", "delivery", "motorcycle", "moped", "private", "hov", "evehicle", "vip")
_PUBLIC_CLASSES = ("bus", "coach", "taxi")
_FARTHEST = 1e8
"""Coordinates beyond this [m] are no place on earth."""

_LARGEST = 1e6
"""A network is no larger [m]: float32 would lose the centimetres, and pictures their lanes."""


@dataclass(frozen=True)
class NetLanes:
    """L lanes as they stand in the file, in the network's coordinates.

    Attributes:
        names: L lane ids. number: row of each id. dropped: ids of lanes that vehicles and bicycles never use.
        edges: L pairs of edge id and index in it. ends: from and to junction by edge id (normal edges).
        shapes: L arrays (P, 2) [m]. width: (L,) [m]. speed: (L,) float32 [m/s]. kind: (L,) uint8. internal: (L,) bool.
        changes: (L, 2) bool whether cars may change to the left, right as far as the lane itself says.
        junctions: outlines by junction id. crossings: outlines (4, 2). lefthand: whether traffic keeps left.
    """

    names: tuple[str, ...]
    number: dict[str, int]
    dropped: frozenset[str]
    edges: list[tuple[str, int]]
    ends: dict[str, tuple[str, str]]
    shapes: list[Points]
    width: NDArray[np.float64]
    speed: NDArray[np.float32]
    kind: NDArray[np.uint8]
    internal: NDArray[np.bool_]
    changes: NDArray[np.bool_]
    junctions: dict[str, Points]
    crossings: list[Points]
    lefthand: bool

    def __len__(self) -> int:
        return len(self.names)

    @property
    def low(self) -> Points:
        """(2,) least coordinates."""
        return np.asarray(np.min([shape.min(0) for shape in self.shapes], axis=0))

    @property
    def high(self) -> Points:
        """(2,) greatest coordinates."""
        return np.asarray(np.max([shape.max(0) for shape in self.shapes], axis=0))


def read_lanes(root: Element, place: str) -> NetLanes:
    """All lanes for vehicles and bicycles below <net>. Raises UnusableInput where there is none or one is unsound."""
    usable: list[tuple[str, str, LaneKind, Element, bool]] = []
    dropped: set[str] = set()
    crossings: list[Points] = []
    ends: dict[str, tuple[str, str]] = {}
    for edge in root.iterfind("edge"):
        function, name = edge.get("function", "normal"), edge.get("id", "")
        for lane in edge.iterfind("lane"):
            kind = None if function in ("crossing", "walkingarea") else _kind(lane)
            if function == "crossing":
                crossings.append(_crossing(lane, place))
            if kind is None:
                dropped.add(lane.get("id", ""))
            else:
                usable.append((lane.get("id", ""), name, kind, lane, function == "internal"))
        if function != "internal":
            ends[name] = (edge.get("from", ""), edge.get("to", ""))
    if not usable:
        raise UnusableInput(f"{place}: the network has no lane for vehicles or bicycles", reason="no-lanes")
    names, edges, kinds, elements, internal = zip(*usable, strict=True)
    if twice := [name for name, times in Counter(names).items() if times > 1]:
        raise UnusableInput(f"{place} has two lanes of the id {twice[0]!r}: rename one of them", reason="bad-map")
    lanes = NetLanes(
        names=names,
        number={name: i for i, name in enumerate(names)},
        dropped=frozenset(dropped),
        edges=[(edge, whole_number(lane, "index", place)) for edge, lane in zip(edges, elements, strict=True)],
        ends=ends,
        shapes=[lane_shape(lane, place) for lane in elements],
        width=np.array([lane_number(lane, "width", DEFAULT_WIDTH, place) for lane in elements]),
        speed=np.array([lane_number(lane, "speed", np.nan, place) for lane in elements], np.float32),
        kind=np.array(kinds, np.uint8),
        internal=np.array(internal, np.bool_),
        changes=np.array([[_may_change(lane.get(side)) for side in ("changeLeft", "changeRight")] for lane in elements]),
        junctions={
            j.get("id", ""): lane_shape(j, place) for j in root.iterfind("junction") if j.get("shape", "").count(" ") >= 2
        },
        crossings=crossings,
        lefthand=root.get("lefthand") in ("true", "1"),
    )
    if (lanes.high - lanes.low).max() > _LARGEST:
        said = f"{place} is more than {_LARGEST / 1000:.0f} km across: repair it, or cut a window out of it"
        raise UnusableInput(f"{said} with `drivegen map import --around X,Y`", reason="too-large")
    return lanes


def whole_number(element: Element, attribute: str, place: str) -> int:
    """A non-negative integer attribute. Raises UnusableInput where it is none."""
    text = element.get(attribute, "")
    if not text.isascii() or not text.isdigit() or len(text) > 6:
        raise UnusableInput(f"{place}: <{element.tag}> has {attribute}={text!r}, which is no count", reason="bad-map")
    return int(text)


def names_unknown_lane(connection: Element, lanes: NetLanes) -> bool:
    """Whether the connection names a lane that is not in the file, rather than one that was left out."""
    ends = (f"{connection.get(a)}_{connection.get(b)}" for a, b in (("from", "fromLane"), ("to", "toLane")))
    return any(end not in lanes.number and end not in lanes.dropped for end in ends)


def lane_shape(element: Element, place: str) -> Points:
    """Points (P, 2) of the attribute shape, "x,y x,y,z ..."; a height is left out. Raises UnusableInput for other text."""
    text = element.get("shape", "")
    try:
        points = np.array([tuple(map(float, point.split(",")[:2])) for point in text.split()], np.float64)
    except ValueError:
        points = np.zeros(0)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not (np.abs(points) < _FARTHEST).all():
        name = element.get("id", "")
        raise UnusableInput(f"{place}: <{element.tag}> {name!r} has a shape that is no line of points", reason="bad-map")
    return points


def lane_number(element: Element, attribute: str, default: float, place: str) -> float:
    """A positive number below 1000, the default where the attribute is absent. Raises UnusableInput for anything else."""
    text = element.get(attribute)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not 0 < value < 1000:
        name = element.get("id", "")
        raise UnusableInput(f"{place}: <{element.tag}> {name!r} has {attribute}={text!r}", reason="bad-map")
    return value


def _kind(lane: Element) -> LaneKind | None:
    """Who may use the lane, by its vehicle classes; None for rails, water and footways."""
    allow, disallow = lane.get("allow") or None, lane.get("disallow", "")  # SUMO takes allow="" for no word
    allowed, forbidden = (allow or "all").split(), disallow.split()

    def may(vehicle_class: str) -> bool:
        if allow is None:
            return vehicle_class not in forbidden and "all" not in forbidden
        return vehicle_class in allowed or "all" in allowed

    if may("passenger"):
        return LaneKind.VEHICLE
    if any(map(may, _PUBLIC_CLASSES)):
        return LaneKind.BUS
    if may("bicycle"):
        return LaneKind.BIKE
    return LaneKind.VEHICLE if any(map(may, _ROAD_CLASSES)) else None


def _may_change(allowed: str | None) -> bool:
    """Whether cars may leave the lane to that side: `allowed` names vehicle classes, absent means all."""
    return allowed is None or not {"all", "passenger"}.isdisjoint(allowed.split())


def _crossing(lane: Element, place: str) -> Points:
    return crossing_corners(lane_shape(lane, place), lane_number(lane, "width", DEFAULT_WIDTH, place))
