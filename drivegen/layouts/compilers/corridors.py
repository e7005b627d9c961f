"""Streets: a road of any alignment, with crossings, side streets or roundabouts along it."""

from typing import NamedTuple

import numpy as np

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import arc_length, resample, rotate
from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.compilers.crossings import HALF_OPENING, MAIN, MINOR, NODE_TYPES, Opening, add_arm, assign_lanes
from drivegen.layouts.compilers.roundabouts import add_ring
from drivegen.layouts.crossings import NO_TURN_LANES, RING_LANE, Arm, Crossing, TurnLanes
from drivegen.layouts.streets import LEAST_ROOM, Corridor, Junction
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork, Point

_STRAIGHT = 2  # points of a straight line
_APART = 0.5
_STEP, _WIDTH, _NEAR_JUNCTION = 4.0, 15.0, 30.0  # [m]
_RING_SPEED = 30 / 3.6
_TAPER = 30.0
_HALF_SHARE = 0.22  # of the way between turn lanes, for half an opening at either of its ends
_TURNING_RADIUS = 9.0
_TURNING_PLACE = 2.6 * _TURNING_RADIUS
_TURNING_SPEED = 15 / 3.6


Pair = tuple[str, str]


class Place(NamedTuple):
    """A node of the main road: its name, how far along the road it lies [m], and its point."""

    node: str
    along: float
    at: Point


def compile_corridor(spec: Corridor, plain: PlainNetwork) -> None:
    """Draw the corridor from (0, 0) to the east."""
    line = lines.draw(spec.alignment)
    if spec.dead_end and min(lines.length(line) - 2 * _TURNING_PLACE, spec.ways()[-1] - LEAST_ROOM) > _TURNING_PLACE:
        # the turning place is a part of the road, where there is room for it
        line = lines.part(line, 0.0, lines.length(line) - _TURNING_PLACE)
    if spec.junctions and spec.alignment.shape == "straight":
        line = line[[0, -1]]
    leaving, end = Place("w", 0.0, _corner(line[0])), Place("e", lines.length(line), _corner(line[-1]))
    plain.nodes += [Node("w", *leaving.at), Node("e", *end.at)]
    for i, junction in enumerate(spec.junctions):
        west, east = _junction(plain, i, junction, line)
        _stretch(plain, spec, line, i, leaving, west)
        leaving = east
    count = len(spec.junctions)
    _stretch(plain, spec, line, count, leaving, end)
    for i, crossing in enumerate(spec.crossings):
        if crossing is not None:
            _assign_lanes(plain, spec, i, crossing)
    if spec.dead_end:
        heading = float(np.arctan2(*(line[-1] - line[-2])[::-1]))
        add_turning_place(plain, "e", end.at, heading, f"m{count}", f"-m{count}", spec.speed)


def add_turning_place(plain: PlainNetwork, node: str, at: Point, heading: float, there: str, back: str, speed: float) -> None:
    """Close a dead end at `node` with a loop that a bus can drive round, from edge `there` to edge `back`.

    Nobody may drive faster on it than on the road, `speed` [m/s]. The loop is a drop: its tangents leave the node, its round
    end lies ahead of it along `heading` [radians].
    """
    distance = 1.6 * _TURNING_RADIUS
    opening = float(np.arcsin(_TURNING_RADIUS / distance))
    around = np.linspace(-np.pi / 2 - opening, np.pi / 2 + opening, 33)
    round_end = np.array([distance, 0.0]) + _TURNING_RADIUS * np.stack([np.cos(around), np.sin(around)], axis=-1)
    drop = np.asarray(at) + rotate(np.concatenate([np.zeros((1, 2)), round_end, np.zeros((1, 2))]), np.asarray(heading))
    half = len(drop) // 2
    tip = f"{node}_turn"
    plain.nodes.append(Node(tip, *_corner(drop[half])))
    limit = min(_TURNING_SPEED, speed)
    for name, a, b, shape in ((f"{tip}1", node, tip, drop[: half + 1]), (f"{tip}2", tip, node, drop[half:])):
        plain.edges.append(Edge(name, a, b, 1, limit, MINOR, lines.points(shape), spread="center", width=4.5))
    for source, target in ((there, f"{tip}1"), (f"{tip}1", f"{tip}2"), (f"{tip}2", back)):
        lanes = {edge.id: edge.lanes for edge in plain.edges}
        ways = range(max(lanes[source], lanes[target]))
        plain.connections += [Connection(source, target, min(i, lanes[source] - 1), min(i, lanes[target] - 1)) for i in ways]


def _stretch(plain: PlainNetwork, spec: Corridor, line: lines.Line, number: int, a: Place, b: Place) -> None:
    """Draw the main road between two junctions or ends, cut where turn lanes open at either of them."""
    name, ways = f"m{number}", len(spec.junctions)
    there = spec.turn_lanes(number) if number < ways else NO_TURN_LANES
    back = spec.turn_lanes(number - 1, back=True) if number else NO_TURN_LANES
    half = min(HALF_OPENING, _HALF_SHARE * (b.along - a.along - back.length - there.length))
    parts = [(name, a, b)]
    if back.left + back.right:
        cut = _place(f"{name}_wp", line, a.along + back.length + half)
        _open(plain, spec, line, cut, half, back, (f"-{name}", f"-{name}_w"), (f"{name}_w", name))
        parts = [(f"{name}_w", a, cut), (name, cut, b)]
    if there.left + there.right:
        cut = _place(f"{name}_ep", line, b.along - there.length - half)
        _open(plain, spec, line, cut, half, there, (name, f"{name}_e"), (f"-{name}_e", f"-{name}"))
        parts = [*parts[:-1], (name, parts[-1][1], cut), (f"{name}_e", cut, b)]
    for part, source, target in parts:
        more = there if part == f"{name}_e" else NO_TURN_LANES
        forth = _shape(spec, line, source, target, more, back=False)
        plain.edges.append(Edge(part, source.node, target.node, spec.lanes + more.left + more.right, spec.speed, MAIN, forth))
        if spec.lanes_back:
            more = back if part == f"{name}_w" else NO_TURN_LANES
            lanes = spec.lanes_back + more.left + more.right
            away = _shape(spec, line, target, source, more, back=True)
            plain.edges.append(Edge(f"-{part}", target.node, source.node, lanes, spec.speed, MAIN, away))


def _open(
    plain: PlainNetwork, spec: Corridor, line: lines.Line, cut: Place, half: float, more: TurnLanes, way: Pair, other: Pair
) -> None:
    """Draw the node where turn lanes open from one edge of a `way` to the next, and the lanes of the `other` way over it."""
    back = way[0].startswith("-")
    ahead, behind = (line[::-1], line) if back else (line, line[::-1])
    lanes, others = (spec.lanes_back, spec.lanes) if back else (spec.lanes, spec.lanes_back)
    others = 0 if spec.median else others  # the node is not paved across a median: the other way goes on beyond it
    edge, far = -_clear(spec, back), -_clear(spec, not back)
    at = lines.length(line) - cut.along if back else cut.along
    beyond = spec.lane_width * others - far if others else edge
    opening = Opening(ahead, at, half, lanes, spec.lane_width, edge, beyond, more)
    plain.nodes.append(opening.node(cut.node))
    plain.connections += opening.connections(*way)
    if others:
        over = Opening(behind, lines.length(line) - at, half, others, spec.lane_width, far, far, NO_TURN_LANES)
        plain.connections += over.connections(*other)


def _place(node: str, line: lines.Line, along: float) -> Place:
    return Place(node, along, _corner(lines.beside(line, np.array([along]), np.zeros(1))[0]))


def _shape(spec: Corridor, line: lines.Line, source: Place, target: Place, more: TurnLanes, back: bool) -> tuple[Point, ...]:
    """The left edge of a piece of the main road, empty where that is the straight way between its nodes."""
    order = -1 if back else 1
    if not (spec.junctions or spec.median):
        return lines.points(line[::order])
    marks = np.array(_edge_marks(spec, source, target, more, back) or [(source.along, 0.0), (target.along, 0.0)])
    if len(line) == _STRAIGHT and not marks[:, 1].any():
        return ()
    along, left = marks[::order, 0], marks[::order, 1]
    bends = arc_length(line)[1:-1]
    inner = bends[(bends > along[0] + _APART) & (bends < along[-1] - _APART)]
    inner = inner[(np.abs(inner[:, None] - along).min(axis=1) > _APART)] if len(inner) else inner
    at = np.sort(np.concatenate([along, inner]))
    return lines.points(lines.beside(line, at, np.interp(at, along, left))[::order])


def _edge_marks(spec: Corridor, source: Place, target: Place, more: TurnLanes, back: bool) -> tuple[tuple[float, float], ...]:
    """How far the left edge of a piece of the main road lies to the left of the road's middle: (distance along, left) [m].

    Empty where no left-turn lane opens and no median lies. Else the lanes that go on keep clear of the middle by as much all
    along the road, so that nobody swerves; only ahead of a ring and of a turning place they come back to the middle, and behind
    them they leave it.
    """
    if not (most := _clear(spec, back)):
        return ()
    start, end = source.along, target.along
    clear = (most - more.left * spec.lane_width) * (1.0 if back else -1.0)
    taper = min(_TAPER, abs(end - start) / 3) * (1.0 if end > start else -1.0)
    first = [(start, 0.0), (start + taper, clear)] if _is_narrow(spec, source) else [(start, clear)]
    last = [(end - taper, clear), (end, 0.0)] if _is_narrow(spec, target) else [(end, clear)]
    return (*first, *last)


def _clear(spec: Corridor, back: bool) -> float:
    """How far the lanes of one direction that go on keep from the road's middle [m]: half the median, and all left-turn lanes."""
    most = max((spec.turn_lanes(i, back).left for i in range(len(spec.junctions))), default=0)
    return spec.lane_width * most + spec.median / 2


def _is_narrow(spec: Corridor, place: Place) -> bool:
    """Whether the road has no room in its middle there: at rings and turning places."""
    name = place.node
    return (name == "e" and spec.dead_end) or any(
        name in (f"j{i}0", f"j{i}1") for i, junction in enumerate(spec.junctions) if junction.form == "roundabout"
    )


def _assign_lanes(plain: PlainNetwork, spec: Corridor, number: int, crossing: Crossing) -> None:
    """Lane connections of all roads into a junction that have turn lanes or bans."""
    sides = _side_names(number, spec.junctions[number])
    at = f"j{number}"
    entering = [next((e.id for e in plain.edges if e.target == at and e.id.startswith(way)), "") for way in ("-m", "m")]
    leaving = [next((e.id for e in plain.edges if e.source == at and e.id.startswith(way)), "") for way in ("m", "-m")]
    exits = [*leaving, *(f"{name}_out" for name in sides)]
    for here in (1, 0, *range(2, len(crossing.arms))):
        edge = [*entering, *(f"{name}_in" for name in sides)][here]
        if edge:
            assign_lanes(plain, crossing, here, edge, exits)


def _junction(plain: PlainNetwork, number: int, junction: Junction, line: lines.Line) -> tuple[Place, Place]:
    """Draw one junction with its side roads; returns where the main road meets it at the near and at the far end."""
    name = f"j{number}"
    centre = _place(name, line, junction.position)
    before, after = (_place("", line, junction.position + metres).at for metres in (-1.0, 1.0))
    heading = _direction(before, after)
    side_angles = [(heading + turn) % 360.0 for turn in junction.directions]
    if len(line) > _STRAIGHT:
        _refuse_meeting_again(line, centre, junction, side_angles)
    if junction.form == "roundabout":
        radius = (junction.diameter - junction.ring_lanes * RING_LANE) / 2
        here, there = (_place("", line, junction.position + metres) for metres in (-radius, radius))
        angles = [_direction(centre.at, here.at), _direction(centre.at, there.at), *side_angles]
        entry, exit_, *sides = add_ring(plain, name, centre.at, angles, junction.ring_lanes, junction.diameter, _RING_SPEED)
        west, east = Place(entry[0], here.along, entry[1]), Place(exit_[0], there.along, exit_[1])
    else:
        plain.nodes.append(Node(name, *centre.at, NODE_TYPES[junction.control]))
        west = east = centre
        sides = [(name, centre.at)] * len(side_angles)
    for side, angle, (node, at) in zip(_side_names(number, junction), side_angles, sides, strict=True):
        _side_road(plain, side, junction, angle, node, at)
    return west, east


def _refuse_meeting_again(line: lines.Line, centre: Place, junction: Junction, angles: list[float]) -> None:
    """Raise UnusableInput where a side road would run into the road that it leaves, behind a bend."""
    road = resample(line, _STEP)
    elsewhere = road[np.abs(arc_length(road) - centre.along) > _NEAR_JUNCTION]
    away = np.arange(_NEAR_JUNCTION, junction.side_length, _STEP)
    for angle in np.radians(angles):
        side = np.asarray(centre.at) + away[:, None] * np.array([np.cos(angle), np.sin(angle)])
        gap = np.linalg.norm(side[:, None] - elsewhere, axis=-1)
        if gap.size and gap.min() < _WIDTH:
            raise UnusableInput(
                f"the side road at {junction.position:.0f} m would run into the road again behind its bend; make it shorter "
                "or let it join on the other side",
                reason="impossible-map",
            )


def _side_names(number: int, junction: Junction) -> list[str]:
    """Names of the side roads of a junction, the first on either side without a number."""
    numbers = [junction.sides[:i].count(side) for i, side in enumerate(junction.sides)]
    return [f"j{number}_{side}{before + 1 if before else ''}" for side, before in zip(junction.sides, numbers, strict=True)]


def _direction(a: Point, b: Point) -> float:
    """The direction from a to b [degrees]."""
    return float(np.degrees(np.arctan2(b[1] - a[1], b[0] - a[0])))


def _side_road(plain: PlainNetwork, name: str, junction: Junction, angle: float, node: str, at: Point) -> None:
    lanes = junction.side_lanes
    arm = Arm(angle=angle, lanes_in=lanes, lanes_out=lanes, speed=junction.side_speed, length=junction.side_length, main=False)
    add_arm(plain, name, arm, node, at, NO_TURN_LANES)
    if junction.dead_end:
        heading = float(np.radians(angle))
        end = (at[0] + arm.length * np.cos(heading), at[1] + arm.length * np.sin(heading))
        add_turning_place(plain, name, end, heading, f"{name}_out", f"{name}_in", arm.speed)


def _corner(point: lines.Line) -> Point:
    return float(point[0]), float(point[1])
