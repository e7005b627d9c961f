"""Streets: a road of any alignment, and a straight one with crossings, side streets or roundabouts along it."""

import numpy as np

from drivegen.geometry import rotate
from drivegen.maps.compilers import _lines as lines
from drivegen.maps.compilers.crossings import MAIN, MINOR, NODE_TYPES, add_arm
from drivegen.maps.compilers.roundabouts import add_ring
from drivegen.maps.spec import Arm, Corridor, Junction
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork, Point

Place = tuple[str, Point]

_RING_SPEED = 30 / 3.6
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
        _stretch(plain, spec, f"m{i}", leaving, west, None)
        leaving = east
    last = f"m{len(spec.junctions)}"
    _stretch(plain, spec, last, leaving, ("e", end), line if not spec.junctions else None)
    if spec.dead_end:
        heading = float(np.arctan2(*(line[-1] - line[-2])[::-1]))
        add_turning_place(plain, "e", end, heading, last, f"-{last}", spec.speed)


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


def _stretch(plain: PlainNetwork, spec: Corridor, name: str, a: Place, b: Place, line: lines.Line | None) -> None:
    shape = lines.points(line) if line is not None else ()
    plain.edges.append(Edge(name, a[0], b[0], spec.lanes, spec.speed, MAIN, shape))
    if spec.lanes_back:
        plain.edges.append(Edge(f"-{name}", b[0], a[0], spec.lanes_back, spec.speed, MAIN, shape[::-1]))


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
