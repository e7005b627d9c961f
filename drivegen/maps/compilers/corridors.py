"""Streets: a road of any alignment, and a straight one with crossings, side streets or roundabouts along it."""

from drivegen.maps.compilers import _lines as lines
from drivegen.maps.compilers.crossings import MAIN, NODE_TYPES, add_arm
from drivegen.maps.compilers.roundabouts import add_ring
from drivegen.maps.spec import Arm, Corridor, Junction
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork, Point

Place = tuple[str, Point]

_RING_SPEED = 30 / 3.6
_TURNING_PLACE = 8.0


def compile_corridor(spec: Corridor, plain: PlainNetwork) -> None:
    """Draw the corridor from (0, 0) to the east."""
    line = lines.draw(spec.alignment)
    start, end = _corner(line[0]), _corner(line[-1])
    plain.nodes.append(Node("w", *start))
    plain.nodes.append(Node("e", *end, radius=_TURNING_PLACE if spec.dead_end else None))
    leaving: Place = ("w", start)
    for i, junction in enumerate(spec.junctions):
        west, east = _junction(plain, f"j{i}", junction)
        _stretch(plain, spec, f"m{i}", leaving, west, None)
        leaving = east
    last = f"m{len(spec.junctions)}"
    _stretch(plain, spec, last, leaving, ("e", end), line if not spec.junctions else None)
    if spec.dead_end:
        turn_back(plain, last, f"-{last}", spec.lanes, spec.lanes_back)


def turn_back(plain: PlainNetwork, there: str, back: str, lanes: int, lanes_back: int) -> None:
    """Let cars turn round at a dead end: from the inner lane into the inner lane."""
    plain.connections.append(Connection(there, back, lanes - 1, lanes_back - 1))


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
        turn_back(plain, f"{name}_out", f"{name}_in", lanes, lanes)


def _corner(point: lines.Line) -> Point:
    return float(point[0]), float(point[1])
