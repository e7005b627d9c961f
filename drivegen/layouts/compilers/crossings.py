"""Crossings of three to eight roads, with pocket lanes for turns, and the arms that roundabouts share with them."""

from collections.abc import Sequence

import numpy as np

from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.crossings import STRAIGHT, Arm, Crossing, TurnLanes
from drivegen.layouts.values import STREET_LANE, Control
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork, Point

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


def compile_crossing(spec: Crossing, plain: PlainNetwork) -> None:
    """Draw the crossing around (0, 0)."""
    plain.nodes.append(Node("c", 0.0, 0.0, NODE_TYPES[spec.control]))
    arms = enumerate(spec.arms)
    edges = [add_arm(plain, f"a{i}", arm, "c", (0.0, 0.0), spec.turn_lanes(i), spec.lane_width) for i, arm in arms]
    for i, edge in enumerate(edges):
        if edge is not None:
            assign_lanes(plain, spec, i, edge, [f"a{k}_out" for k in range(len(edges))])


def add_arm(
    plain: PlainNetwork, name: str, arm: Arm, node: str, at: Point, pockets: TurnLanes, width: float = STREET_LANE
) -> str | None:
    """Draw the road `name` out from `node` at point `at`; returns the id of the edge that enters the node, if any."""
    direction = np.array([np.cos(np.radians(arm.angle)), np.sin(np.radians(arm.angle))])
    start = np.asarray(at)
    far = start + arm.length * direction
    plain.nodes.append(Node(name, float(far[0]), float(far[1])))
    priority = MAIN if arm.main else MINOR
    left, right, length = pockets
    if left + right == 0:
        if arm.lanes_out:
            plain.edges.append(Edge(f"{name}_out", node, name, arm.lanes_out, arm.speed, priority))
        if arm.lanes_in:
            plain.edges.append(Edge(f"{name}_in", name, node, arm.lanes_in, arm.speed, priority))
        return f"{name}_in" if arm.lanes_in else None
    middle = start + length * direction
    plain.nodes.append(Node(f"{name}_p", float(middle[0]), float(middle[1])))
    if arm.lanes_out:
        plain.edges.append(Edge(f"{name}_out", node, f"{name}_p", arm.lanes_out, arm.speed, priority))
        plain.edges.append(Edge(f"{name}_away", f"{name}_p", name, arm.lanes_out, arm.speed, priority))
    # The through lanes keep clear of the middle, so that left pockets open there and nobody swerves.
    approach = lines.part(np.stack([far, middle]), 0.0, float(np.linalg.norm(far - middle)), -width * left)
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
    ways += [(lanes - 1, lanes + right + i) for i in range(left)] + [(0, i) for i in range(right)]
    plain.connections += [Connection(before, after, a, b) for a, b in ways]


def assign_lanes(plain: PlainNetwork, crossing: Crossing, here: int, edge: str, exits: Sequence[str]) -> None:
    """Lane connections of an approach with turn lanes or bans: turn lanes turn, the lanes between go on, or turn where none does.

    `edge` comes in over arm `here`; `exits` lead out over each arm.
    """
    turns, (left, right, _) = crossing.turns(here), crossing.turn_lanes(here)
    if not (left or right or crossing.arms[here].turn_bans):
        return
    first, last = right, right + crossing.arms[here].lanes_in - 1  # the lanes that go on
    for other, turn in turns.items():
        lanes = crossing.arms[other].lanes_out
        if turn > STRAIGHT:
            ways = [(last + left - i, lanes - 1 - i) for i in range(min(max(left, 1), lanes))]
        elif turn < -STRAIGHT:
            ways = [(i, i) for i in range(min(max(right, 1), lanes))]
        else:
            ways = [(lane, min(lane - first, lanes - 1)) for lane in range(first, last + 1)]
        plain.connections += [Connection(edge, exits[other], a, b) for a, b in ways]
    if all(abs(turn) > STRAIGHT for turn in turns.values()):
        _use_idle_lanes(plain, edge, crossing, here, exits)


def _use_idle_lanes(plain: PlainNetwork, edge: str, crossing: Crossing, here: int, exits: Sequence[str]) -> None:
    """Where no road goes straight on (the stem of a T), lanes without a pocket's turn take the gentlest turn."""
    turns, right = crossing.turns(here), crossing.turn_lanes(here).right
    other = min(turns, key=lambda i: (abs(turns[i]), i))
    used_lanes = {c.source_lane for c in plain.connections if c.source == edge}
    for lane in range(right, right + crossing.arms[here].lanes_in):
        if lane not in used_lanes:
            plain.connections.append(Connection(edge, exits[other], lane, min(lane, crossing.arms[other].lanes_out - 1)))
