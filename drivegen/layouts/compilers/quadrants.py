"""Interchanges with loops: two highways on different levels, their ramps drawn as arcs in the quadrants between them.

Carriageway i heads east, north, west or south (i = 0 to 3) and leaves the bridge beside quadrant i; quadrant i - 1 lies beside
it before the bridge. The loop of quadrant i leads from carriageway i to i + 1, the direct ramp around the corner from i + 1 to
i. All is drawn for traffic on the right and a road that may lack its northern leg behind a loop in the north-west; other ways
round are the same ones turned or driven backwards.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import radians
from typing import Any, NamedTuple

import numpy as np

from drivegen.layouts.alignment import Alignment
from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.compilers._quadrant_plans import ACCELERATION, WEST, Plan, StreetPlan
from drivegen.layouts.compilers.crossings import MAIN, MINOR, NODE_TYPES
from drivegen.layouts.compilers.highways import RampEnds, add_backwards, add_carriageway
from drivegen.layouts.compilers.interchanges import HEIGHT
from drivegen.layouts.highways import Highway, HighwayEvent
from drivegen.layouts.quadrants import QUADRANTS, QuadrantInterchange
from drivegen.layouts.values import HIGHWAY_LANE, Control
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork

_DECELERATION = 150.0
"""Length of the lane from which a direct ramp leaves [m]."""

_BESIDE_LOOP = 150.0
"""Length of the lane before or behind a loop that has no other one on the far side of the bridge [m]."""

_LANES_CHANGE = 60.0
"""A road that ends has its lanes change so far before the bridge, or behind it [m]."""

_PRIORITY = 6
_CARRIAGEWAYS = "hugv"
_NORTH, _SOUTH = 1, 3
_OPPOSITE = {"north": "south", "south": "north", "east": "west", "west": "east"}


def compile_quadrants(spec: QuadrantInterchange, plain: PlainNetwork) -> None:
    """Draw the highway from west to east and the road from south to north over (0, 0)."""
    if spec.control is not None:
        _draw_over_street(StreetPlan(spec), spec.control, plain)
    elif not spec.south_leg:
        turned = PlainNetwork()
        compile_quadrants(_exchanged(spec, "north", "south", "east", "west"), turned)
        turned = turned.mapped(lambda point: (-point[0], -point[1]))
        plain.nodes, plain.edges = plain.nodes + turned.nodes, plain.edges + turned.edges
        plain.connections += turned.connections
    elif not spec.north_leg and spec.north_east == "both":
        backwards = PlainNetwork()
        compile_quadrants(_exchanged(spec, "east", "west"), backwards)
        add_backwards(backwards, plain)
    else:
        _draw(Plan(spec), plain)


def _exchanged(spec: QuadrantInterchange, *directions: str) -> QuadrantInterchange:
    """The specification with these directions and their opposites exchanged in the names of quadrants and legs."""

    def renamed(name: str) -> str:
        return "_".join(_OPPOSITE[part] if part in directions else part for part in name.split("_"))

    return spec.model_copy(update={renamed(name): getattr(spec, name) for name in (*QUADRANTS, "north_leg", "south_leg")})


class _Happens(NamedTuple):
    """An event along a carriageway, with the ramps that join and leave there, "" none."""

    event: HighwayEvent
    joins: str = ""
    leaves: str = ""


@dataclass
class _Ramps:
    """Where ramps end as carriageways note it, and by each ramp's own name its stubs there, whose connections it takes over."""

    ends: RampEnds = field(default_factory=dict)
    begin: dict[str, str] = field(default_factory=dict)
    finish: dict[str, str] = field(default_factory=dict)


def _draw(plan: Plan, plain: PlainNetwork) -> None:
    upper, ramps = PlainNetwork(), _Ramps()
    for i in range(4):
        _draw_carriageway(plan, plain if i % 2 == 0 else upper, ramps, i)
    plain.nodes += [replace(node, z=HEIGHT) for node in upper.nodes]
    plain.edges += [replace(edge, heights=(HEIGHT, HEIGHT)) for edge in upper.edges]
    plain.connections += [replace(link, heights=(HEIGHT, HEIGHT)) for link in upper.connections]
    for name in ramps.begin:
        _draw_ramp(plan, plain, ramps, name)


def _draw_over_street(plan: StreetPlan, control: Control, plain: PlainNetwork) -> None:
    """The highway and, above it, a street with crossings at which ramps end."""
    ramps = _Ramps()
    for i in (0, 2):
        _draw_carriageway(plan, plain, ramps, i)
    stops = {f"t{k}": y for k, y in enumerate(sorted({plan.terminal(name) for name in plan.ramps}))}
    plain.nodes += [Node(name, 0.0, y, NODE_TYPES[control], z=HEIGHT) for name, y in stops.items()]
    beyond = plan.spec.leg_length
    ends = {"t_south": min(0.0, *stops.values()) - beyond, "t_north": max(0.0, *stops.values()) + beyond}
    plain.nodes += [Node(name, 0.0, y, z=HEIGHT) for name, y in ends.items()]
    for a, b in pairwise(sorted({**stops, **ends}.items(), key=lambda stop: stop[1])):
        for source, target in ((a[0], b[0]), (b[0], a[0])):
            plain.edges.append(Edge(f"{source}_{target}", source, target, plan.spec.road_lanes, plan.spec.road_speed, MAIN))
    for name in plan.ramps:
        y = plan.terminal(name)
        node = next(stop for stop, at in stops.items() if at == y)
        for ends_of in (ramps.begin, ramps.finish):
            if name not in ends_of:
                ends_of[name] = f"{name}_street"
                ramps.ends[ends_of[name]] = (node, (0.0, y))
        _draw_ramp(plan, plain, ramps, name)


def _draw_carriageway(plan: Plan, plain: PlainNetwork, ramps: _Ramps, i: int) -> None:
    spec, name = plan.spec, _CARRIAGEWAYS[i]
    start, end = -plan.leg, plan.leg
    lanes, speed = (spec.road_lanes, spec.road_speed) if i % 2 else (spec.lanes, spec.speed)
    if spec.trumpet and i == _NORTH:
        end = plan.top
    if spec.trumpet and i == _SOUTH:
        start, lanes = -plan.top, plan.lanes
    highway = Highway(alignment=Alignment(length=end - start), lanes=lanes, speed=speed, median=spec.median)
    happens = _along(plan, i, start)
    heading = radians(90.0 * i)
    axis = np.outer([start, end], [np.cos(heading), np.sin(heading)])
    add_carriageway(highway, plain, name, axis, tuple(one.event for one in happens), ramps.ends)
    for k, one in enumerate(happens):
        ramps.finish |= {one.joins: f"{name}ramp{k}_in"} if one.joins else {}
        ramps.begin |= {one.leaves: f"{name}ramp{k}_out"} if one.leaves else {}
    if spec.trumpet and i == _NORTH:
        ramps.begin[f"direct{WEST}"] = _goes_on(plan, plain, ramps, plain.edges[-1], joins=False)
    if spec.trumpet and i == _SOUTH:
        first = next(edge for edge in plain.edges if edge.id == f"{name}1")
        ramps.finish[f"loop{WEST}"] = _goes_on(plan, plain, ramps, first, joins=True)


def _goes_on(plan: Plan, plain: PlainNetwork, ramps: _Ramps, edge: Edge, joins: bool) -> str:
    """Note that a carriageway ends in a ramp, or begins as one; returns the name of the ramp's stub."""
    stub, node, point = f"{edge.id}_ramp", *((edge.source, edge.shape[0]) if joins else (edge.target, edge.shape[-1]))
    ramps.ends[stub] = (node, point)
    pair = (stub, edge.id) if joins else (edge.id, stub)
    plain.connections += [Connection(*pair, lane, lane) for lane in range(plan.lanes)]
    return stub


def _along(plan: Plan, i: int, start: float) -> list[_Happens]:
    """What happens along carriageway i, which begins at `start`, in order."""
    before, here, near = (i - 1) % 4, i, plan.near(i)
    events: list[_Happens] = []

    def event(kind: str, at: float, length: float, **more: Any) -> HighwayEvent:
        fields = {"kind": kind, "position": at - start, "length": length, "lanes": plan.lanes, **more}
        return HighwayEvent.model_validate(fields)

    if plan.spec.trumpet and i % 2 and plan.spec.road_lanes > plan.lanes:
        kind, at = ("lane_drop", -_LANES_CHANGE) if i == _NORTH else ("lane_gain", _LANES_CHANGE)
        events.append(_Happens(event(kind, at, 50.0, lanes=plan.spec.road_lanes - plan.lanes)))
    if plan.direct(before) and not (plan.spec.trumpet and i == _SOUTH):
        off = event("off_ramp", -plan.far(i, before) - _DECELERATION, _DECELERATION)
        events.append(_Happens(off, leaves=f"direct{before}"))
    joins = f"loop{before}" if plan.loops(before) and not (plan.spec.trumpet and i == _SOUTH) else ""
    leaves = f"loop{here}" if plan.loops(here) else ""
    if joins and leaves:
        events.append(_Happens(event("weaving", -near, 2 * near), joins, leaves))
    elif joins:
        events.append(_Happens(event("on_ramp", -near, _BESIDE_LOOP), joins))
    elif leaves:
        events.append(_Happens(event("off_ramp", near - _BESIDE_LOOP, _BESIDE_LOOP), leaves=leaves))
    if plan.direct(here):
        events.append(_Happens(event("on_ramp", plan.far(i, here), ACCELERATION), f"direct{here}"))
    return sorted(events, key=lambda one: one.event.position)


def _draw_ramp(plan: Plan, plain: PlainNetwork, ramps: _Ramps, name: str) -> None:
    """Draw a ramp as one edge between its carriageways, and give it the connections of its stubs."""
    stubs = (ramps.begin[name], ramps.finish[name])
    (source, start), (target, end) = (ramps.ends[stub] for stub in stubs)
    loop, q = name.startswith("loop"), int(name[-1])
    line = plan.line(name, start)
    speed = plan.spec.loop_speed if loop else plan.spec.ramp_speed
    shape = (start, *lines.points(line[1:-1]), end)
    heights = (HEIGHT, 0.0) if q % 2 == loop else (0.0, HEIGHT)
    priority = _PRIORITY if plan.spec.control is None else MINOR
    plain.edges.append(Edge(name, source, target, plan.lanes, speed, priority, shape, width=HIGHWAY_LANE, heights=heights))
    renamed = dict.fromkeys(stubs, name)
    plain.connections = [
        replace(c, source=renamed.get(c.source, c.source), target=renamed.get(c.target, c.target)) for c in plain.connections
    ]
