"""Crossings of three to eight roads, with pocket lanes for turns, and the arms that roundabouts share with them."""

import numpy as np

from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.crossings import Arm, Crossing
from drivegen.layouts.values import Control
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork, Point

LANE_WIDTH = 3.2
"""Width of a lane of a street [m], SUMO's own."""

NODE_TYPES: dict[Control, str] = {
    "signals": "traffic_light",
    "all_way_stop": "allway_stop",
    "stop": "priority_stop",
    "yield": "priority",
    "uncontrolled": "right_before_left",
}
"""SUMO's node types for our words."""

MAIN, MINOR = 3, 1
"""Edge priorities of main and side roads."""

_STRAIGHT = 40.0


def compile_crossing(spec: Crossing, plain: PlainNetwork) -> None:
    """Draw the crossing around (0, 0)."""
    plain.nodes.append(Node("c", 0.0, 0.0, NODE_TYPES[spec.control]))
    ways_in = [add_arm(plain, f"a{i}", arm, "c", (0.0, 0.0), _turns(spec.arms, i)) for i, arm in enumerate(spec.arms)]
    for i, edge in enumerate(ways_in):
        if edge is not None and _has_pocket(spec.arms[i], _turns(spec.arms, i)):
            _assign_lanes(plain, edge, spec.arms, i)


def add_arm(plain: PlainNetwork, name: str, arm: Arm, node: str, at: Point, turns: dict[int, float]) -> str | None:
    """Draw the road `name` out from `node` at point `at`; returns the id of the edge that enters the node, if any.

    `turns` maps the other arms with a way out to the turn towards them [degrees, left positive]: a turn lane is drawn
    only where there is such a turn.
    """
    direction = np.array([np.cos(np.radians(arm.angle)), np.sin(np.radians(arm.angle))])
    start = np.asarray(at)
    far = start + arm.length * direction
    plain.nodes.append(Node(name, float(far[0]), float(far[1])))
    priority = MAIN if arm.main else MINOR
    left, right = _pockets(arm, turns) if arm.lanes_in else (0, 0)
    if left + right == 0:
        if arm.lanes_out:
            plain.edges.append(Edge(f"{name}_out", node, name, arm.lanes_out, arm.speed, priority))
        if arm.lanes_in:
            plain.edges.append(Edge(f"{name}_in", name, node, arm.lanes_in, arm.speed, priority))
        return f"{name}_in" if arm.lanes_in else None
    middle = start + min(arm.pocket, arm.length / 2) * direction
    plain.nodes.append(Node(f"{name}_p", float(middle[0]), float(middle[1])))
    if arm.lanes_out:
        plain.edges.append(Edge(f"{name}_out", node, f"{name}_p", arm.lanes_out, arm.speed, priority))
        plain.edges.append(Edge(f"{name}_away", f"{name}_p", name, arm.lanes_out, arm.speed, priority))
    # The through lanes keep clear of the middle by one lane, so that the left pocket opens there and nobody swerves.
    approach = lines.part(np.stack([far, middle]), 0.0, float(np.linalg.norm(far - middle)), -LANE_WIDTH * left)
    plain.edges += [
        Edge(f"{name}_in", name, f"{name}_p", arm.lanes_in, arm.speed, priority, lines.points(approach)),
        Edge(f"{name}_pocket", f"{name}_p", node, arm.lanes_in + left + right, arm.speed, priority),
    ]
    open_pockets(plain, f"{name}_in", f"{name}_pocket", arm.lanes_in, left, right)
    return f"{name}_pocket"


def open_pockets(plain: PlainNetwork, before: str, after: str, lanes: int, left: int, right: int) -> None:
    """Connect edge `before` of so many lanes with `after`, which has `left` and `right` turn lanes more beside them, if any."""
    if not left + right:
        return
    ways = [(lane, lane + right) for lane in range(lanes)]
    ways += [(lanes - 1, lanes + right)] * left + [(0, 0)] * right
    plain.connections += [Connection(before, after, a, b) for a, b in ways]


def _turns(arms: tuple[Arm, ...], here: int) -> dict[int, float]:
    """The turn [degrees in (-180, 180), left positive] from arm `here` to every other arm with a way out."""
    heading = arms[here].angle + 180.0
    others = [i for i, arm in enumerate(arms) if i != here and arm.lanes_out]
    return {i: (arms[i].angle - heading + 180.0) % 360.0 - 180.0 for i in others}


def _pockets(arm: Arm, turns: dict[int, float]) -> tuple[int, int]:
    left = arm.left_turn_lane and any(turn > _STRAIGHT for turn in turns.values())
    right = arm.right_turn_lane and any(turn < -_STRAIGHT for turn in turns.values())
    return int(left), int(right)


def _has_pocket(arm: Arm, turns: dict[int, float]) -> bool:
    return any(_pockets(arm, turns))


def _assign_lanes(plain: PlainNetwork, edge: str, arms: tuple[Arm, ...], here: int) -> None:
    """Lane connections of an approach with pockets: pocket lanes turn, the lanes between go on."""
    turns = _turns(arms, here)
    left, right = _pockets(arms[here], turns)
    first, last = right, right + arms[here].lanes_in - 1  # the lanes that go on
    for other, turn in sorted(turns.items()):
        exit_edge, exit_lanes = f"a{other}_out", arms[other].lanes_out
        if turn > _STRAIGHT:
            ways = [(last + left, exit_lanes - 1)]
        elif turn < -_STRAIGHT:
            ways = [(first - right, 0)]
        else:
            ways = [(lane, min(lane - first, exit_lanes - 1)) for lane in range(first, last + 1)]
        plain.connections += [Connection(edge, exit_edge, a, b) for a, b in ways]
    if all(abs(turn) > _STRAIGHT for turn in turns.values()):
        _use_idle_lanes(plain, edge, arms, turns, range(first, last + 1))


def _use_idle_lanes(plain: PlainNetwork, edge: str, arms: tuple[Arm, ...], turns: dict[int, float], idle: range) -> None:
    """Where no road goes straight on (the stem of a T), lanes without a pocket's turn take the gentlest turn."""
    other = min(turns, key=lambda i: (abs(turns[i]), i))
    taken = {c.source_lane for c in plain.connections if c.source == edge}
    for lane in idle:
        if lane not in taken:
            plain.connections.append(Connection(edge, f"a{other}_out", lane, min(lane, arms[other].lanes_out - 1)))
