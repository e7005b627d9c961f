"""A network in SUMO's plain XML: nodes, edges, connections, roundabouts, as netconvert reads them.

Format: SUMO, "PlainXML". Lane 0 is the outermost (rightmost in right-hand traffic). Only these types are ever
written, so whatever a model or a file says, netconvert sees our own serialisation.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise
from xml.etree.ElementTree import Element, SubElement, tostring

Point = tuple[float, float]

_XSD = "http://sumo.dlr.de/xsd"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"


@dataclass(frozen=True)
class Node:
    """A place where edges meet.

    Attributes:
        x, y: position [m]. type: SUMO's word, e.g. "priority", "traffic_light", "allway_stop".
        shape: outline given by hand; edges then keep their full length up to it. See `point_shape`.
        radius: of the corners [m], None for netconvert's own choice. z: height [m], of bridges.
    """

    id: str
    x: float
    y: float
    type: str = "priority"
    shape: tuple[Point, ...] | None = None
    radius: float | None = None
    z: float = 0.0


@dataclass(frozen=True)
class Lane:
    """What one lane of an edge has of its own: width [m], who may use it ("" everybody), centreline, speed [m/s]."""

    width: float | None = None
    allow: str = ""
    shape: tuple[Point, ...] = ()
    speed: float | None = None


@dataclass(frozen=True)
class Edge:
    """Lanes from one node to another.

    Attributes:
        lanes: number of lanes. speed: [m/s]. priority: higher goes first at a junction.
        shape: reference line [m], ends included, or empty for a straight line between the nodes.
        spread: "right" (the line is the lanes' left edge) or "center".
        width: of each lane [m], None for SUMO's 3.2 m.
        per_lane: as many `Lane`s as lanes, or none.
        heights: of the first and last point of its shape [m], those between climb evenly along it; () flat. Without a shape
            an edge climbs from node to node.
    """

    id: str
    source: str
    target: str
    lanes: int
    speed: float
    priority: int = 1
    shape: tuple[Point, ...] = ()
    spread: str = "right"
    width: float | None = None
    per_lane: tuple[Lane, ...] = ()
    heights: tuple[float, ...] = ()


@dataclass(frozen=True)
class Connection:
    """A way from a lane of one edge to a lane of another; naming any for an edge replaces netconvert's guesses for it.

    `shape` is the centreline inside the node [m], ends included, with `heights` as an edge's; without it netconvert draws one.
    """

    source: str
    target: str
    source_lane: int
    target_lane: int
    shape: tuple[Point, ...] = ()
    heights: tuple[float, ...] = ()


@dataclass(frozen=True)
class Roundabout:
    """A ring: ids of its nodes and edges."""

    nodes: tuple[str, ...]
    edges: tuple[str, ...]


@dataclass
class PlainNetwork:
    """Everything that netconvert needs; `lefthand` mirrors which side lane 0 is on."""

    nodes: list[Node] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    connections: list[Connection] = field(default_factory=list)
    roundabouts: list[Roundabout] = field(default_factory=list)
    lefthand: bool = False

    def mapped(self, place: Callable[[Point], Point]) -> "PlainNetwork":
        """The network with every point of it taken elsewhere by `place`."""

        def each(points: tuple[Point, ...]) -> tuple[Point, ...]:
            return tuple(map(place, points))

        def moved(node: Node) -> Node:
            x, y = place((node.x, node.y))
            return replace(node, x=x, y=y, shape=node.shape and each(node.shape))

        def drawn(edge: Edge) -> Edge:
            lanes = tuple(replace(lane, shape=each(lane.shape)) for lane in edge.per_lane)
            return replace(edge, shape=each(edge.shape), per_lane=lanes)

        connections = [replace(link, shape=each(link.shape)) for link in self.connections]
        return replace(self, nodes=[*map(moved, self.nodes)], edges=[*map(drawn, self.edges)], connections=connections)

    def files(self) -> dict[str, bytes]:
        """The plain XML files by name, byte-identical for equal networks."""
        return {"net.nod.xml": self._nodes(), "net.edg.xml": self._edges(), "net.con.xml": self._connections()}

    def _nodes(self) -> bytes:
        root = _root("nodes")
        for node in self.nodes:
            element = SubElement(root, "node", id=node.id, x=_number(node.x), y=_number(node.y), type=node.type)
            if node.shape is not None:
                element.set("shape", _points(node.shape))
            if node.z:
                element.set("z", _number(node.z))
            if node.radius is not None:
                element.set("radius", _number(node.radius))
        return _bytes(root)

    def _edges(self) -> bytes:
        root = _root("edges")
        for edge in self.edges:
            element = SubElement(root, "edge", {"id": edge.id, "from": edge.source, "to": edge.target})
            element.set("numLanes", str(edge.lanes))
            element.set("speed", _number(edge.speed))
            element.set("priority", str(edge.priority))
            element.set("spreadType", edge.spread)
            if edge.width is not None:
                element.set("width", _number(edge.width))
            if edge.shape:
                element.set("shape", _points(edge.shape, edge.heights))
            for index, lane in enumerate(edge.per_lane):
                _lane(SubElement(element, "lane", index=str(index)), lane)
        for ring in self.roundabouts:
            SubElement(root, "roundabout", nodes=" ".join(ring.nodes), edges=" ".join(ring.edges))
        return _bytes(root)

    def _connections(self) -> bytes:
        root = _root("connections")
        for link in self.connections:
            element = SubElement(root, "connection", {"from": link.source, "to": link.target})
            element.set("fromLane", str(link.source_lane))
            element.set("toLane", str(link.target_lane))
            if link.shape:
                element.set("shape", _points(link.shape, link.heights))
        return _bytes(root)


def point_shape(x: float, y: float) -> tuple[Point, ...]:
    """A junction outline of next to no size: netconvert then cuts nothing off the lanes that meet at (x, y)."""
    return ((x, y), (x + 0.01, y), (x, y + 0.01))


def _lane(element: Element, lane: Lane) -> None:
    if lane.width is not None:
        element.set("width", _number(lane.width))
    if lane.speed is not None:
        element.set("speed", _number(lane.speed))
    if lane.allow:
        element.set("allow", lane.allow)
    if lane.shape:
        element.set("shape", _points(lane.shape))


def _root(tag: str) -> Element:
    # The schema's name makes netconvert validate elements and enumerations against its own local copy.
    return Element(tag, {"xmlns:xsi": _XSI, "xsi:noNamespaceSchemaLocation": f"{_XSD}/{tag}_file.xsd"})


def _bytes(root: Element) -> bytes:
    text: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    return text


def _number(value: float) -> str:
    return f"{value:.3f}".rstrip("0").rstrip(".")


def _points(points: tuple[Point, ...], heights: tuple[float, ...] = ()) -> str:
    if not heights:
        return " ".join(f"{x:.3f},{y:.3f}" for x, y in points)
    along = [0.0, *accumulate(math.dist(a, b) for a, b in pairwise(points))]
    climbed = [heights[0] + (heights[1] - heights[0]) * at / along[-1] for at in along]
    return " ".join(f"{x:.3f},{y:.3f},{z:.3f}" for (x, y), z in zip(points, climbed, strict=True))
