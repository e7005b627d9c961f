"""SUMO plain XML that somebody else wrote, read as data: what passes is our own types, and nothing else goes on.

netconvert includes local files through entities, hangs on entity bombs, accepts 100 000 lanes and crashes on -1, so it never
sees this text: size cap, no DTD, known elements and attributes only, every value in a range, ids unique, references held.
What is wrong is told line by line, for the writer that repairs it.
"""

import re
from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar
from xml.etree.ElementTree import Element

from drivegen.core.errors import UnusableInput
from drivegen.core.safe_xml import parse
from drivegen.sumo.plain import Connection, Edge, Lane, Node, PlainNetwork, Point, Roundabout

MAX_BYTES = 64 * 1024
"""Of each of the three files; a network of scenario size takes a tenth."""

MOST_PROBLEMS = 10
_NODES, _EDGES, _CONNECTIONS, _RINGS = 200, 400, 1000, 20
_POINTS = 100
_FAR = 5000.0
_NAME = re.compile(r"[A-Za-z0-9_.\-]{1,32}")
_NUMBER = re.compile(r"[+-]?\d{1,9}(?:\.\d{1,9})?", re.ASCII)
_WHOLE = re.compile(r"\d{1,3}", re.ASCII)
_NODE_TYPES = {
    *("priority", "traffic_light", "right_before_left", "left_before_right", "unregulated", "priority_stop", "allway_stop"),
    *("zipper", "dead_end"),
}
_SPREADS = {"right", "center", "roadCenter"}
_ROOT_ATTRIBUTES = {"version", "{http://www.w3.org/2001/XMLSchema-instance}noNamespaceSchemaLocation"}
_CHILDREN = {"nodes": ("node",), "edges": ("edge", "roundabout"), "connections": ("connection",)}
_REQUIRED: Mapping[str, frozenset[str]] = {
    "node": frozenset({"id", "x", "y"}),
    "edge": frozenset({"id", "from", "to", "numLanes", "speed"}),
    "lane": frozenset({"index"}),
    "roundabout": frozenset({"nodes", "edges"}),
    "connection": frozenset({"from", "to", "fromLane", "toLane"}),
}
_OPTIONAL: Mapping[str, frozenset[str]] = {
    "node": frozenset({"type", "radius"}),
    "edge": frozenset({"priority", "shape", "spreadType", "width"}),
    "lane": frozenset({"speed", "width"}),
    "roundabout": frozenset(),
    "connection": frozenset(),
}

T = TypeVar("T")


class UnusableXml(UnusableInput):
    """The text is no network that may be built. `problems` are at most ten lines, each naming the element at fault."""

    def __init__(self, problems: Collection[str]) -> None:
        self.problems = tuple(problems)[:MOST_PROBLEMS]
        super().__init__(f"the XML cannot be used: {self.problems[0]}", reason="unusable-xml")


def read_plain(nodes: str, edges: str, connections: str, left_hand: bool = False) -> PlainNetwork:
    """The network that the three texts describe. Raises UnusableXml with everything that is wrong, ten lines at most."""
    reader = _Reader()
    roots = [reader.root(text, tag) for text, tag in ((nodes, "nodes"), (edges, "edges"), (connections or "", "connections"))]
    reader.stop_if_wrong()  # what cannot be parsed has no elements to speak of
    network = PlainNetwork(
        nodes=reader.every(roots[0], "node", _NODES, reader.node),
        edges=reader.every(roots[1], "edge", _EDGES, reader.edge),
        roundabouts=reader.every(roots[1], "roundabout", _RINGS, reader.roundabout),
        connections=reader.every(roots[2], "connection", _CONNECTIONS, reader.connection),
        lefthand=left_hand,
    )
    reader.stop_if_wrong()
    _hangs_together(network, reader.wrong)
    reader.stop_if_wrong()
    return network


class _Wrong(Exception):
    """One element cannot be read; its words go to the list."""


class _Reader:
    """Elements to our types; what is wrong is collected in `wrong`."""

    def __init__(self) -> None:
        self.wrong: list[str] = []

    def stop_if_wrong(self) -> None:
        if self.wrong:
            raise UnusableXml(list(dict.fromkeys(self.wrong)))

    def root(self, text: str, tag: str) -> Element:
        if tag == "connections" and not text.strip():
            return Element(tag)
        try:
            root = parse(text.encode("utf-8", "replace"), tag, root=tag, max_bytes=MAX_BYTES)
        except UnusableInput as error:
            self.wrong.append(str(error))
            return Element(tag)
        if unknown := sorted(set(root.attrib) - _ROOT_ATTRIBUTES):
            self.wrong.append(f"<{tag}> may not have the attribute {_shown(unknown[0])}")
        if foreign := [child.tag for child in root if child.tag not in _CHILDREN[tag]]:
            self.wrong.append(f"<{tag}> may hold {' and '.join(_CHILDREN[tag])} only, not <{_shown(foreign[0])}>")
        return root

    def every(self, root: Element, tag: str, most: int, read: Callable[[Element], T]) -> list[T]:
        """All children called `tag`, `most` at most."""
        items: list[T] = []
        elements = root.findall(tag)
        if len(elements) > most:
            self.wrong.append(f"<{root.tag}> holds {len(elements)} elements <{tag}>, more than {most}")
        for element in elements[:most]:
            try:
                items.append(read(element))
            except _Wrong as problem:
                self.wrong.append(str(problem))
        return items

    def node(self, element: Element) -> Node:
        attributes = _attributes(element)
        shape = attributes.get("type", "priority")
        if shape not in _NODE_TYPES:
            raise _Wrong(f"node {attributes['id']}: type must be one of {', '.join(sorted(_NODE_TYPES))}, not {_shown(shape)}")
        x, y = (_number(element, name, -_FAR, _FAR) for name in ("x", "y"))
        return Node(attributes["id"], x, y, shape, radius=_number(element, "radius", 0, 50) if "radius" in attributes else None)

    def edge(self, element: Element) -> Edge:
        attributes = _attributes(element, "from", "to")
        lanes = _whole(element, "numLanes", 1, 8)
        spread = attributes.get("spreadType", "right")
        if spread not in _SPREADS:
            raise _Wrong(
                f"edge {attributes['id']}: spreadType must be one of {', '.join(sorted(_SPREADS))}, not {_shown(spread)}"
            )
        return Edge(
            id=attributes["id"],
            source=attributes["from"],
            target=attributes["to"],
            lanes=lanes,
            speed=_number(element, "speed", 3, 45),
            priority=_whole(element, "priority", 0, 100) if "priority" in attributes else 1,
            shape=_line(element),
            spread=spread,
            width=_number(element, "width", 2, 6) if "width" in attributes else None,
            per_lane=_lanes(element, lanes),
        )

    def roundabout(self, element: Element) -> Roundabout:
        nodes, edges = (_attributes(element)[name].split()[:_POINTS] for name in ("nodes", "edges"))
        return Roundabout(tuple(nodes), tuple(edges))

    def connection(self, element: Element) -> Connection:
        ends = _attributes(element, "from", "to")
        return Connection(ends["from"], ends["to"], _whole(element, "fromLane", 0, 7), _whole(element, "toLane", 0, 7))


def _attributes(element: Element, *names: str) -> dict[str, str]:
    """The element's attributes, none unknown or missing; `id` and `names` are ids."""
    attributes = dict(element.attrib)
    here = f"{element.tag} {_shown(attributes.get('id', ''))}".strip()
    if missing := sorted(_REQUIRED[element.tag] - set(attributes)):
        raise _Wrong(f"{here}: the attribute {missing[0]} is missing")
    if unknown := sorted(set(attributes) - _REQUIRED[element.tag] - _OPTIONAL[element.tag]):
        raise _Wrong(f"{here}: the attribute {_shown(unknown[0])} is not allowed")
    for name in ("id", *names):
        if name in attributes and not _NAME.fullmatch(attributes[name]):
            raise _Wrong(f"{here}: {name} must be 1 to 32 letters, digits, _ . or -")
    if element.tag != "edge" and len(element):
        raise _Wrong(f"{here}: may hold nothing")
    return attributes


def _number(element: Element, name: str, low: float, high: float) -> float:
    text = element.get(name, "")
    if not _NUMBER.fullmatch(text) or not low <= float(text) <= high:
        raise _Wrong(f"{element.tag} {_shown(element.get('id', ''))}: {name} must be {low:g} to {high:g}, not {_shown(text)}")
    return float(text)


def _whole(element: Element, name: str, low: int, high: int) -> int:
    text = element.get(name, "")
    if not _WHOLE.fullmatch(text) or not low <= int(text) <= high:
        here = element.get("id", element.get("from", ""))
        raise _Wrong(f"{element.tag} {_shown(here)}: {name} must be a whole number {low} to {high}, not {_shown(text)}")
    return int(text)


def _line(edge: Element) -> tuple[Point, ...]:
    pairs = [pair.split(",") for pair in edge.get("shape", "").split()]
    here = f"edge {_shown(edge.get('id', ''))}: shape"
    if len(pairs) == 1 or len(pairs) > _POINTS:
        raise _Wrong(f"{here} must have 2 to {_POINTS} points, not {len(pairs)}")
    for pair in pairs:
        if len(pair) != 2 or not all(_NUMBER.fullmatch(n) and abs(float(n)) <= _FAR for n in pair):
            raise _Wrong(f"{here} must be points x,y within {_FAR:g} m, not {_shown(','.join(pair))}")
    return tuple((float(x), float(y)) for x, y in pairs)


def _lanes(edge: Element, count: int) -> tuple[Lane, ...]:
    if not len(edge):
        return ()
    lanes = [Lane()] * count
    if repeated := _twice([element.get("index") for element in edge]):
        raise _Wrong(f"edge {_shown(edge.get('id', ''))}: two lanes have the index {_shown(repeated[0])}")
    for element in edge:
        if element.tag != "lane":
            raise _Wrong(f"edge {_shown(edge.get('id', ''))}: may hold lane only, not <{_shown(element.tag)}>")
        attributes = _attributes(element)
        index = _whole(element, "index", 0, count - 1)
        width, speed = (_number(element, n, *r) if n in attributes else None for n, r in (("width", (2, 6)), ("speed", (3, 45))))
        lanes[index] = Lane(width=width, speed=speed)
    return tuple(lanes)


def _hangs_together(network: PlainNetwork, wrong: list[str]) -> None:
    """Ids are unique, whatever is referred to is there, edges join two different nodes, no two nodes share a place."""
    nodes, edges = {n.id: n for n in network.nodes}, {e.id: e for e in network.edges}
    if not nodes or not edges:
        wrong.append("there must be nodes and edges")
    for what, items in (("nodes", network.nodes), ("edges", network.edges)):
        wrong += [f"two {what} have the id {name}" for name in _twice([item.id for item in items])]
    wrong += [f"two nodes lie at {x:g},{y:g}" for x, y in _twice([(round(n.x), round(n.y)) for n in network.nodes])]
    for edge in network.edges:
        wrong += [f"edge {edge.id}: there is no node {name}" for name in (edge.source, edge.target) if name not in nodes]
        if edge.source == edge.target:
            wrong.append(f"edge {edge.id} begins and ends at the node {edge.source}")
    wrong += [line for link in network.connections for line in _broken(link, edges)]
    wrong += [f"two connections are the same: {one.source} to {one.target}" for one in _twice(network.connections)]
    for ring in network.roundabouts:
        lost = [name for name in ring.nodes if name not in nodes] + [name for name in ring.edges if name not in edges]
        wrong += [f"roundabout: there is no {_shown(name)}" for name in lost[:1]]


def _broken(link: Connection, edges: Mapping[str, Edge]) -> list[str]:
    here = f"connection {link.source} to {link.target}"
    if lost := [name for name in (link.source, link.target) if name not in edges]:
        return [f"{here}: there is no edge {lost[0]}"]
    source, target = edges[link.source], edges[link.target]
    if source.target != target.source:
        return [f"{here}: the first must end at the node where the second begins"]
    if link.source_lane >= source.lanes or link.target_lane >= target.lanes:
        return [f"{here}: fromLane must be below {source.lanes}, toLane below {target.lanes}"]
    return []


def _twice(items: list[Any]) -> list[Any]:
    seen: set[Any] = set()
    return [item for item in items if item in seen or seen.add(item)]  # type: ignore[func-returns-value]


def _shown(text: str) -> str:
    """Foreign text as it may stand in a message: short, printable, in one line."""
    short = "".join(c if c.isprintable() else "?" for c in str(text)[:40])
    return short + ("..." if len(str(text)) > 40 else "")
