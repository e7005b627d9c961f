"""Streets: a road of any alignment, and a straight one with crossings, side streets or roundabouts along it."""

import numpy as np

from drivegen.geometry import rotate
from drivegen.maps.compilers import _lines as lines
from drivegen.maps.compilers.crossings import LANE_WIDTH, MAIN, MINOR, NODE_TYPES, add_arm, open_pockets
from drivegen.maps.compilers.roundabouts import add_ring
from drivegen.maps.spec import NO_TURN_LANES, Arm, Corridor, Junction, TurnLanes
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork, Point

Place = tuple[str, Point]

_RING_SPEED = 30 / 3.6
_TAPER = 30.0
_TURNING_RADIUS = 9.0
_TURNING_PLACE = 2.6 * _TURNING_RADIUS
_TURNING_SPEED = 15 / 3.6


def compile_corridor(spec: Corridor, plain: PlainNetwork) -> None:
    """Draw the corridor from (0, 0) to the east."""
    line = lines.draw(spec.alignment)
    if spec.dead_end and lines.length(line) > 3 * _TURNING_PLACE:  # the turning place is a part of the road
        line = lines.part(line, 0.0, lines.length(line) - _TURNING_PLACE)
    start, end = _corner(line[0]), _corner(line[-1])
    plain.nodes.append(Node("w", *start))
    plain.nodes.append(Node("e", *end))
    leaving: Place = ("w", start)
    for i, junction in enumerate(spec.junctions):
        west, east = _junction(plain, f"j{i}", junction)
        _stretch(plain, spec, i, leaving, west, None)
        leaving = east
    count = len(spec.junctions)
    _stretch(plain, spec, count, leaving, ("e", end), line if not spec.junctions else None)
    for i in range(count):
        _assign_lanes(plain, spec, i, back=False)
        _assign_lanes(plain, spec, i, back=True)
    if spec.dead_end:
        heading = float(np.arctan2(*(line[-1] - line[-2])[::-1]))
        add_turning_place(plain, "e", end, heading, f"m{count}", f"-m{count}", spec.speed)


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


def _stretch(plain: PlainNetwork, spec: Corridor, number: int, a: Place, b: Place, line: lines.Line | None) -> None:
    """Draw the main road between two junctions or ends, cut where turn lanes open at either of them."""
    name, ways = f"m{number}", len(spec.junctions)
    there = spec.turn_lanes(number) if number < ways else NO_TURN_LANES
    back = spec.turn_lanes(number - 1, back=True) if number else NO_TURN_LANES
    parts = [(name, a, b)]
    if back.left + back.right:
        cut = _cut(plain, f"{name}_wp", a[1][0] + back.length)
        parts = [(f"{name}_w", a, cut), (name, cut, b)]
    if there.left + there.right:
        cut = _cut(plain, f"{name}_ep", b[1][0] - there.length)
        parts = [*parts[:-1], (name, parts[-1][1], cut), (f"{name}_e", cut, b)]
    for part, source, target in parts:
        shape = lines.points(line) if line is not None else ()
        more = there if part == f"{name}_e" else NO_TURN_LANES
        forth = _beside(spec, source, target, more, back=False) or shape
        plain.edges.append(Edge(part, source[0], target[0], spec.lanes + more.left + more.right, spec.speed, MAIN, forth))
        if spec.lanes_back:
            more = back if part == f"{name}_w" else NO_TURN_LANES
            lanes = spec.lanes_back + more.left + more.right
            away = _beside(spec, target, source, more, back=True) or shape[::-1]
            plain.edges.append(Edge(f"-{part}", target[0], source[0], lanes, spec.speed, MAIN, away))
    open_pockets(plain, name, f"{name}_e", spec.lanes, there.left, there.right)
    open_pockets(plain, f"-{name}", f"-{name}_w", spec.lanes_back, back.left, back.right)


def _cut(plain: PlainNetwork, name: str, x: float) -> Place:
    plain.nodes.append(Node(name, x, 0.0))
    return name, (x, 0.0)


def _beside(spec: Corridor, source: Place, target: Place, more: TurnLanes, back: bool) -> tuple[Point, ...]:
    """The left edge of a straight piece of the main road, empty where that is the middle of the road.

    Where left-turn lanes open, the lanes that go on keep clear of the middle by one lane all along the road, so that nobody
    swerves; only ahead of a ring and of a turning place they come back to the middle, and behind them they leave it.
    """
    if not any(spec.turn_lanes(i, back).left for i in range(len(spec.junctions))):
        return ()
    (start, _), (end, _) = source[1], target[1]
    clear = (LANE_WIDTH - more.left * LANE_WIDTH) * (1.0 if back else -1.0)
    taper = min(_TAPER, abs(end - start) / 3) * (1.0 if end > start else -1.0)
    first = [(start, 0.0), (start + taper, clear)] if _is_narrow(spec, source) else [(start, clear)]
    last = [(end - taper, clear), (end, 0.0)] if _is_narrow(spec, target) else [(end, clear)]
    return (*first, *last)


def _is_narrow(spec: Corridor, place: Place) -> bool:
    """Whether the road has no room in its middle there: at rings and turning places."""
    name = place[0]
    return (name == "e" and spec.dead_end) or any(
        name in (f"j{i}0", f"j{i}1") for i, junction in enumerate(spec.junctions) if junction.form == "roundabout"
    )


def _assign_lanes(plain: PlainNetwork, spec: Corridor, number: int, back: bool) -> None:
    """Lane connections of an approach with turn lanes: those turn, the lanes between go on."""
    more, junction = spec.turn_lanes(number, back), spec.junctions[number]
    if not more.left + more.right:
        return
    entering = f"-m{number + 1}_w" if back else f"m{number}_e"
    lanes = spec.lanes_back if back else spec.lanes
    leaving = next(e.id for e in plain.edges if e.source == f"j{number}" and e.id.startswith("-m" if back else "m"))
    plain.connections += [Connection(entering, leaving, lane + more.right, lane) for lane in range(lanes)]
    left, right = ("right", "left") if back else ("left", "right")
    if left in junction.sides:
        last = more.right + lanes - 1 + more.left
        plain.connections.append(Connection(entering, f"j{number}_{left}_out", last, junction.side_lanes - 1))
    if right in junction.sides:
        plain.connections.append(Connection(entering, f"j{number}_{right}_out", 0, 0))


def _junction(plain: PlainNetwork, name: str, junction: Junction) -> tuple[Place, Place]:
    """Draw one junction with its side roads; returns where the main road meets it in the west and in the east."""
    centre = (junction.position, 0.0)
    side_angles = [90.0 if side == "left" else 270.0 for side in junction.sides]
    if junction.form == "roundabout":
        angles = [180.0, 0.0, *side_angles]
        west, east, *sides = add_ring(plain, name, centre, angles, junction.ring_lanes, junction.diameter, _RING_SPEED)
    else:
        plain.nodes.append(Node(name, *centre, NODE_TYPES[junction.control]))
        west = east = (name, centre)
        sides = [west] * len(side_angles)
    for side, angle, (node, at) in zip(junction.sides, side_angles, sides, strict=True):
        _side_road(plain, f"{name}_{side}", junction, angle, node, at)
    return west, east


def _side_road(plain: PlainNetwork, name: str, junction: Junction, angle: float, node: str, at: Point) -> None:
    lanes = junction.side_lanes
    arm = Arm(angle=angle, lanes_in=lanes, lanes_out=lanes, speed=junction.side_speed, length=junction.side_length, main=False)
    add_arm(plain, name, arm, node, at, {})
    if junction.dead_end:
        heading = float(np.radians(angle))
        end = (at[0] + arm.length * np.cos(heading), at[1] + arm.length * np.sin(heading))
        add_turning_place(plain, name, end, heading, f"{name}_out", f"{name}_in", arm.speed)


def _corner(point: lines.Line) -> Point:
    return float(point[0]), float(point[1])
