"""Interchanges: a highway with ramps that end at crossings on a road above it, which crosses the highway without a junction."""

from itertools import pairwise

from drivegen.layouts.alignment import Alignment
from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.compilers.crossings import MAIN, MINOR, NODE_TYPES
from drivegen.layouts.compilers.highways import add_carriageway
from drivegen.layouts.highways import Highway, HighwayEvent, Interchange
from drivegen.layouts.values import HIGHWAY_LANE
from drivegen.sumo.plain import Edge, Node, PlainNetwork

HEIGHT = 6.0
"""Of the road above the highway [m]; ramps climb to it."""

_LEAVES, _LENGTH = 400.0, 1400.0
_DECELERATION, _ACCELERATION = 150.0, 200.0
_AWAY = 95.0

_Ramps = tuple[tuple[str, ...], tuple[str, ...]]
_RAMPS: dict[str, _Ramps] = {
    "diamond": (("off_ramp", "on_ramp"), ("off_ramp", "on_ramp")),
    "half_diamond": (("off_ramp",), ("on_ramp",)),
    "side": (("off_ramp", "on_ramp"), ()),
    "terminal": (("off_ramp",), ()),
}


def compile_interchange(spec: Interchange, plain: PlainNetwork) -> None:
    """Draw the highway from west to east and the road from south to north over its middle."""
    south, north = _RAMPS[spec.form]
    _draw_highway(spec, plain, (south, north))
    _draw_road(spec, plain, bool(south), bool(north))
    for name, kinds in (("h", south), ("g", north)):
        for i, kind in enumerate(kinds):
            _lead_on(spec, plain, f"{name}ramp{i}_{'out' if kind == 'off_ramp' else 'in'}", f"road_{name}")


def _draw_highway(spec: Interchange, plain: PlainNetwork, ramps: _Ramps) -> None:
    common = {"lanes": spec.ramp_lanes, "ramp_speed": spec.ramp_speed}
    events = {
        "off_ramp": HighwayEvent.model_validate(
            {"kind": "off_ramp", "position": _LEAVES - _DECELERATION, "length": _DECELERATION, **common}
        ),
        "on_ramp": HighwayEvent.model_validate(
            {"kind": "on_ramp", "position": _LENGTH - _LEAVES, "length": _ACCELERATION, **common}
        ),
    }
    highway = Highway(alignment=Alignment(length=_LENGTH), lanes=spec.lanes, speed=spec.speed)
    axis = lines.draw(highway.alignment)
    for name, line, kinds in (("h", axis, ramps[0]), ("g", axis[::-1], ramps[1])):
        add_carriageway(highway, plain, name, line, tuple(events[kind] for kind in kinds))


def _draw_road(spec: Interchange, plain: PlainNetwork, south: bool, north: bool) -> None:
    """The road from south to north, with a crossing on each side of the highway where ramps end."""
    away = _AWAY + spec.lanes * HIGHWAY_LANE
    stops = [("road_s", -away - spec.road_length), ("road_n", away + spec.road_length)]
    crossings = [("road_h", -away)] * south + [("road_g", away)] * north
    for name, y in (*stops, *crossings):
        kind = NODE_TYPES[spec.control] if (name, y) in crossings else "priority"
        plain.nodes.append(Node(name, _LENGTH / 2, y, kind, z=HEIGHT))
    for (a, _), (b, _) in pairwise(sorted((*stops, *crossings), key=lambda stop: stop[1])):
        for source, target in ((a, b), (b, a)):
            name = f"{source}_{target.removeprefix('road_')}"
            plain.edges.append(Edge(name, source, target, spec.road_lanes, spec.road_speed, MAIN))


def _lead_on(spec: Interchange, plain: PlainNetwork, ramp: str, crossing: str) -> None:
    """Lead a ramp on to its crossing, or from there."""
    far = f"{ramp}_end"
    source, target = (far, crossing) if ramp.endswith("out") else (crossing, far)
    plain.edges.append(Edge(f"{ramp}_road", source, target, spec.ramp_lanes, spec.ramp_speed, MINOR))
