"""Highways and forks: carriageways of their own, ramps over auxiliary lanes, lanes that end, begin or part.

A carriageway is cut where its number of lanes changes. Its reference line is the left edge of its leftmost lane, so
lanes that join or leave on the right leave the others exactly straight; at every cut the lanes are connected by hand.
"""

from dataclasses import dataclass, replace

import numpy as np

from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.highways import Fork, Highway, HighwayEvent
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork, Point

_RAMP_LENGTH = 180.0
_SHORTEST_RAMP = 60.0
_RAMP_AWAY = 32.0
_PRIORITY, _RAMP_PRIORITY = 9, 6
_HALF_CUT = 2.0
_HALF_TAPER = 1.1
"""Lanes open over twice this time [s] at the speed of the road: one changes lanes in it with about 4 m/s2 sideways."""

_FORK_RADIUS = 150.0


RampEnds = dict[str, tuple[str, Point]]
"""By a ramp's name: the node of the carriageway where it begins or ends, and the left edge of its left lane there."""


@dataclass
class _Carriageway:
    """A carriageway while it is drawn: its line, how far it is drawn, lanes there, and how far its left edge has moved.

    `width` is that of its lanes, `room` how long its next ramp may be, so that it does not cross another one, `taper` half the
    length over which lanes open next [m]. `ends` takes where ramps begin and end, by their names, where somebody else draws them.
    """

    name: str
    line: lines.Line
    speed: float
    lanes: int
    width: float
    drawn: float = 0.0
    left: float = 0.0
    cuts: int = 0
    room: float = np.inf
    taper: float = _HALF_CUT
    ends: RampEnds | None = None

    @property
    def node(self) -> str:
        return f"{self.name}n{self.cuts}"

    @property
    def last_edge(self) -> str:
        return f"{self.name}{self.cuts}"


def compile_highway(spec: Highway, plain: PlainNetwork) -> None:
    """Draw one or two carriageways along the alignment, the first one heading east from near (0, 0)."""
    axis = lines.draw(spec.alignment)
    add_carriageway(spec, plain, "h", axis, spec.events)
    if spec.carriageways == 2:
        add_carriageway(spec, plain, "g", axis[::-1], spec.events if spec.both else ())


def compile_fork(spec: Fork, plain: PlainNetwork) -> None:
    """Draw a one-way road heading east that splits at (0, 0), or two that become one there."""
    if spec.joins:
        split = PlainNetwork()
        _draw_split(spec, split)
        add_backwards(split, plain)
    else:
        _draw_split(spec, plain)


def add_backwards(split: PlainNetwork, plain: PlainNetwork) -> None:
    """Add a network driven backwards and seen in a mirror across its way, so that lanes stay on the right."""
    seen = split.mapped(lambda point: (-point[0], point[1]))
    plain.nodes += seen.nodes
    plain.edges += [
        replace(e, source=e.target, target=e.source, shape=e.shape[::-1], heights=e.heights[::-1]) for e in seen.edges
    ]
    plain.connections += [
        Connection(c.target, c.source, c.target_lane, c.source_lane, c.shape[::-1], c.heights[::-1]) for c in seen.connections
    ]


def _draw_split(spec: Fork, plain: PlainNetwork) -> None:
    stem = np.array([[-spec.stem_length, 0.0], [0.0, 0.0]])
    way = _Carriageway("h", stem, spec.speed, spec.lanes, spec.lane_width)
    _begin(plain, way)
    _draw_to(plain, way, spec.stem_length, spec.lanes)
    for name, lanes, side in (("left", spec.left_lanes, 1.0), ("right", spec.right_lanes, -1.0)):
        first = spec.lanes - lanes if side > 0 else 0
        edge_line = _branch(side * np.radians(spec.angle / 2), spec.length)
        offset = 0.0 if side > 0 else -(spec.lanes - lanes) * spec.lane_width
        shape = lines.part(edge_line, 0.0, lines.length(edge_line), offset)
        plain.nodes.append(Node(name, float(shape[-1][0]), float(shape[-1][1])))
        branch = Edge(f"{name}_branch", way.node, name, lanes, spec.speed, _PRIORITY, lines.points(shape), width=spec.lane_width)
        plain.edges.append(branch)
        plain.connections += [Connection(way.last_edge, branch.id, first + lane, lane) for lane in range(lanes)]


def _branch(turn: float, length: float) -> lines.Line:
    angle = np.linspace(0.0, abs(turn), 12)
    arc = _FORK_RADIUS * np.stack([np.sin(angle), np.copysign(1.0, turn) * (1 - np.cos(angle))], axis=-1)
    straight = max(20.0, length - _FORK_RADIUS * abs(turn))
    return np.concatenate([arc, arc[-1:] + straight * np.array([[np.cos(turn), np.sin(turn)]])])


def add_carriageway(
    spec: Highway,
    plain: PlainNetwork,
    name: str,
    axis: lines.Line,
    events: tuple[HighwayEvent, ...],
    ends: RampEnds | None = None,
) -> None:
    """Draw the carriageway that runs along `axis`, with ramps `{name}ramp{i}_in` and `_out`: only noted in `ends`, if given."""
    line = lines.part(axis, 0.0, lines.length(axis), -spec.median / 2 if spec.carriageways == 2 else 0.0)
    stretch = lines.length(line) / spec.alignment.length if spec.alignment.shape == "straight" else 1.0
    way = _Carriageway(name, line, spec.speed, spec.lanes, spec.lane_width, ends=ends)
    _begin(plain, way)
    for i, event in enumerate(events):
        way.room, start = _room(events, i), event.position * stretch
        following = events[i + 1].position * stretch if i + 1 < len(events) else lines.length(line)
        way.taper = _taper(way, event, start, following)
        _event(plain, way, event, f"{name}ramp{i}", start)
    _draw_to(plain, way, lines.length(line), 0)


def _room(events: tuple[HighwayEvent, ...], i: int) -> float:
    """Half the way between an off-ramp and the on-ramp after it, for either of the two."""
    leaving = i if events[i].kind in ("off_ramp", "weaving") else i - 1
    if not 0 <= leaving < len(events) - 1 or events[leaving].kind not in ("off_ramp", "weaving"):
        return float("inf")
    if events[leaving + 1].kind not in ("on_ramp", "weaving"):
        return float("inf")
    gap = events[leaving + 1].position - events[leaving].position - events[leaving].length
    return max(20.0, gap / 2 - 10.0)


def _taper(way: _Carriageway, event: HighwayEvent, start: float, following: float) -> float:
    """Half the length [m] over which the event's lanes open: as the speed wants it, if there is room on both sides."""
    opens = event.kind == "lane_gain" or (event.kind == "off_ramp" and not event.change)
    behind = event.length if event.kind == "off_ramp" else following - start
    room = 0.45 * min(start - way.drawn, behind)
    return max(_HALF_CUT, min(_HALF_TAPER * way.speed, room)) if opens else _HALF_CUT


def _event(plain: PlainNetwork, way: _Carriageway, event: HighwayEvent, ramp: str, start: float) -> None:
    if event.kind in ("lane_drop", "lane_gain"):
        widest = way.lanes + (event.lanes if event.kind == "lane_gain" else 0)
        _draw_to(plain, way, start, widest, left_too=event.side == "left", half=way.taper)
        _change_lanes(plain, way, event)
        return
    if event.change:
        _change_at_ramp(plain, way, event, ramp, start)
        return
    main, extra = way.lanes, event.lanes
    _draw_to(plain, way, start, main + extra, half=way.taper)
    entered, way.lanes = way.last_edge, main + extra
    auxiliary = f"{way.name}{way.cuts + 1}"
    _connect(plain, way, (entered, auxiliary), [(lane, lane + extra) for lane in range(main)], main, way.left)
    if event.kind in ("on_ramp", "weaving"):
        _add_ramp(plain, way, f"{ramp}_in", event, start, main, joins=True)
        plain.connections += [Connection(f"{ramp}_in", auxiliary, lane, lane) for lane in range(extra)]
    else:
        _connect(plain, way, (entered, auxiliary), [(0, lane) for lane in range(extra)], main, way.left)
    _draw_to(plain, way, start + event.length, main + extra)
    way.lanes = main
    after = f"{way.name}{way.cuts + 1}"
    plain.connections += [Connection(auxiliary, after, lane + extra, lane) for lane in range(main)]
    if event.kind in ("off_ramp", "weaving"):
        _add_ramp(plain, way, f"{ramp}_out", event, start + event.length, main, joins=False)
        plain.connections += [Connection(auxiliary, f"{ramp}_out", lane, lane) for lane in range(extra)]


def _change_at_ramp(plain: PlainNetwork, way: _Carriageway, event: HighwayEvent, ramp: str, start: float) -> None:
    """A ramp whose lanes are the carriageway's outer ones, before it leaves or after it has joined."""
    joins, main = event.kind == "on_ramp", way.lanes + min(0, event.change)
    at = start if joins else start + event.length
    _draw_to(plain, way, at, main + event.lanes)
    before, way.lanes = way.last_edge, way.lanes + event.change
    name, after = f"{ramp}_in" if joins else f"{ramp}_out", f"{way.name}{way.cuts + 1}"
    _add_ramp(plain, way, name, event, at, main, joins)
    shift = event.lanes if joins else 0
    plain.connections += [Connection(before, after, lane + event.lanes - shift, lane + shift) for lane in range(main)]
    pair = (name, after) if joins else (before, name)
    plain.connections += [Connection(*pair, lane, lane) for lane in range(event.lanes)]


def _change_lanes(plain: PlainNetwork, way: _Carriageway, event: HighwayEvent) -> None:
    """Lanes end or begin on one side; on the left that moves the carriageway's left edge."""
    before, left, entered = way.lanes, way.left, way.last_edge
    way.lanes += event.lanes if event.kind == "lane_gain" else -event.lanes
    change = way.lanes - before
    shift = change if event.side == "right" else 0
    way.left += change * way.width if event.side == "left" else 0.0
    going_on = range(max(0, -shift), min(before, before if change > 0 else way.lanes - shift))
    edges = entered, f"{way.name}{way.cuts + 1}"
    _connect(plain, way, edges, [(lane, lane + shift) for lane in going_on], before, left)
    if change > 0:  # the outermost lane on that side also leads into the new ones
        source, new = (0, range(change)) if event.side == "right" else (before - 1, range(before, way.lanes))
        _connect(plain, way, edges, [(source, lane) for lane in new], before, left)


def _connect(
    plain: PlainNetwork, way: _Carriageway, edges: tuple[str, str], pairs: list[tuple[int, int]], lanes: int, left: float
) -> None:
    """Connect pairs of lanes over the cut just made: before it there are `lanes` beside the left edge `left` [m].

    Over a long cut each lane is drawn, else netconvert would draw straight lines from end to end, in bends as well.
    """
    for source, target in pairs:
        begin = left - (lanes - source - 0.5) * way.width
        end = way.left - (way.lanes - target - 0.5) * way.width
        drawn = lines.swerve(way.line, way.drawn, way.taper, (begin, end)) if way.taper > _HALF_CUT else ()
        plain.connections.append(Connection(*edges, source, target, drawn))


def _begin(plain: PlainNetwork, way: _Carriageway) -> None:
    x, y = way.line[0]
    plain.nodes.append(Node(way.node, float(x), float(y)))


def _draw_to(
    plain: PlainNetwork, way: _Carriageway, end: float, widest: int, left_too: bool = False, half: float = _HALF_CUT
) -> None:
    """Draw the carriageway on to `end` [m] and put a node there, `widest` lanes wide, `half` long; 0 for the end of the road.

    What is wider than the carriageway lies to its right, or on both sides where `left_too`.
    """
    shape = lines.part(way.line, way.drawn, end, way.left)
    source = way.node
    way.cuts += 1
    way.drawn = end
    x, y = shape[-1]
    left, right = way.left + (widest - way.lanes) * way.width * left_too, way.left - widest * way.width
    cut = lines.strip(way.line, end, half, (left, left), (right, right)) if widest else None
    plain.nodes.append(Node(way.node, float(x), float(y), shape=cut))
    edge = Edge(way.last_edge, source, way.node, way.lanes, way.speed, _PRIORITY, lines.points(shape), width=way.width)
    plain.edges.append(edge)


def _add_ramp(plain: PlainNetwork, way: _Carriageway, name: str, event: HighwayEvent, at: float, main: int, joins: bool) -> None:
    """A ramp that runs in (or out) beside the `main` lanes, tangent to them at distance `at`."""
    if way.ends is not None:
        beside = lines.beside(way.line, np.array([at]), np.array([way.left - main * way.width]))
        way.ends[name] = (way.node, lines.points(beside)[0])
        return
    room = at if joins else lines.length(way.line) - at
    length = min(_RAMP_LENGTH, max(room, _SHORTEST_RAMP), way.room)
    share = np.linspace(1.0, 0.0, 25)
    away = way.left - main * way.width - _RAMP_AWAY * (length / _RAMP_LENGTH) * share**2
    shape = lines.beside(way.line, at - (length if joins else -length) * share, away)
    shape = shape if joins else shape[::-1]
    x, y = shape[0] if joins else shape[-1]
    far = f"{name}_end"
    plain.nodes.append(Node(far, float(x), float(y)))
    source, target = (far, way.node) if joins else (way.node, far)
    edge = Edge(name, source, target, event.lanes, event.ramp_speed, _RAMP_PRIORITY, lines.points(shape), width=way.width)
    plain.edges.append(edge)
