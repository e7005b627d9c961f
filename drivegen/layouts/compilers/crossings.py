"""Crossings of three to eight roads, with pocket lanes for turns, and the arms that roundabouts share with them."""

from collections.abc import Sequence
from typing import NamedTuple

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

HALF_OPENING = 15.0
"""Turn lanes open over twice this [m] before they have their full width, if there is room."""


class Opening(NamedTuple):
    """Where turn lanes open ahead of a crossing.

    Attributes:
        line: of the road, the way one drives. at: the middle of the opening along it [m]. half: of its length [m].
        lanes, width: of the road before it. edge: how far the left edge of these lanes lies to the left of the line [m].
        beyond: the same of the far edge of the lanes the other way; `edge` where there are none.
        more: the turn lanes.
    """

    line: lines.Line
    at: float
    half: float
    lanes: int
    width: float
    edge: float
    beyond: float
    more: TurnLanes

    def node(self, name: str) -> Node:
        """The node that it lies in."""
        left, right, _ = self.more
        x, y = lines.points(lines.beside(self.line, np.array([self.at]), np.zeros(1)))[0]
        far, near = self.beyond, self.edge - self.width * self.lanes
        sides = (far, max(far, self.edge + self.width * left)), (near, near - self.width * right)
        return Node(name, x, y, shape=lines.strip(self.line, self.at, self.half, *sides))

    def connections(self, before: str, after: str) -> list[Connection]:
        """Lanes of edge `before` lead into those of edge `after`, the outermost also into the turn lanes beside them."""
        left, right, _ = self.more
        ways = [(lane, lane + right) for lane in range(self.lanes)]
        ways += [(self.lanes - 1, self.lanes + right + i) for i in range(left)] + [(0, i) for i in range(right)]
        outer = self.edge - self.width * (self.lanes - 0.5)  # the middle of lane 0
        ends = [(outer + self.width * a, outer + self.width * (b - right)) for a, b in ways]
        shapes = [lines.swerve(self.line, self.at, self.half, end) for end in ends]
        return [Connection(before, after, a, b, shape) for (a, b), shape in zip(ways, shapes, strict=True)]


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
    left, right, length = pockets
    line, half, apart = np.stack([far, start]), min(HALF_OPENING, (arm.length - length) / 4), arm.median / 2

    def edge(of: str, a: str, b: str, lanes: int, shape: tuple[Point, ...]) -> None:
        plain.edges.append(Edge(f"{name}_{of}", a, b, lanes, arm.speed, MAIN if arm.main else MINOR, shape))

    if left + right == 0:
        if arm.lanes_out:
            edge("out", node, name, arm.lanes_out, _beside(line[::-1], 0.0, arm.length, apart))
        if arm.lanes_in:
            edge("in", name, node, arm.lanes_in, _beside(line, 0.0, arm.length, apart))
        return f"{name}_in" if arm.lanes_in else None
    # The through lanes keep clear of the middle, so that left pockets open there and nobody swerves.
    kept, others = -width * left - apart, 0 if apart else arm.lanes_out  # the node is not paved across a median
    opening = Opening(
        line, arm.length - length - half, half, arm.lanes_in, width, kept, width * others if others else kept, pockets
    )
    plain.nodes.append(opening.node(f"{name}_p"))
    if arm.lanes_out:
        cut = arm.length - opening.at
        edge("out", node, f"{name}_p", arm.lanes_out, _beside(line[::-1], 0.0, cut, apart))
        edge("away", f"{name}_p", name, arm.lanes_out, _beside(line[::-1], cut, arm.length, apart))
    edge("in", name, f"{name}_p", arm.lanes_in, lines.points(lines.part(line, 0.0, opening.at, kept)))
    edge("pocket", f"{name}_p", node, arm.lanes_in + left + right, _beside(line, opening.at, arm.length, apart))
    plain.connections += opening.connections(f"{name}_in", f"{name}_pocket")
    return f"{name}_pocket"


def _beside(line: lines.Line, start: float, end: float, apart: float) -> tuple[Point, ...]:
    """The left edge of lanes that keep `apart` [m] from the middle of the road, empty where they do not."""
    return lines.points(lines.part(line, start, end, -apart)) if apart else ()


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
