"""From a specification to a SUMO network: draw it, mirror it where traffic keeps left, let netconvert build it."""

from dataclasses import replace
from typing import Any

from drivegen.layouts.compilers.corridors import compile_corridor
from drivegen.layouts.compilers.crossings import compile_crossing
from drivegen.layouts.compilers.graphs import compile_graph
from drivegen.layouts.compilers.grids import compile_grid
from drivegen.layouts.compilers.highways import compile_fork, compile_highway
from drivegen.layouts.compilers.interchanges import compile_interchange
from drivegen.layouts.compilers.quadrants import compile_quadrants
from drivegen.layouts.compilers.roundabouts import compile_roundabout
from drivegen.layouts.spec import MapSpec
from drivegen.layouts.values import STREET_LANE
from drivegen.sumo.netconvert import plain_to_net
from drivegen.sumo.plain import PlainNetwork

_COMPILERS: dict[str, Any] = {
    "crossing": compile_crossing,
    "roundabout": compile_roundabout,
    "corridor": compile_corridor,
    "grid": compile_grid,
    "highway": compile_highway,
    "fork": compile_fork,
    "interchange": compile_interchange,
    "quadrant_interchange": compile_quadrants,
    "graph": compile_graph,
}

_OTHER_SIDE = {"left": "right", "right": "left"}
_OTHER_PART = {**_OTHER_SIDE, "north": "south", "south": "north"}

_OTHER_RULE = {"right_before_left": "left_before_right"}
"""In left-hand traffic netconvert reads these words as seen in a mirror: whoever comes from the right goes first there, too."""


def compile_map(spec: MapSpec) -> bytes:
    """The SUMO network of a specification: same specification, same bytes.

    Raises UnusableInput where the specification cannot be drawn or netconvert refuses it.
    """
    return plain_to_net(draw(spec))


def draw(spec: MapSpec) -> PlainNetwork:
    """The plain network of a specification. Left-hand traffic is drawn as right-hand traffic seen in a mirror."""
    plain = PlainNetwork(lefthand=spec.left_hand)
    road = spec.road
    if spec.left_hand:
        road = type(road).model_validate(_reflected(road.model_dump()))
    _COMPILERS[road.kind](road, plain)
    if (width := getattr(road, "lane_width", STREET_LANE)) != STREET_LANE:
        plain.edges = [replace(edge, width=edge.width or width) for edge in plain.edges]
    if not spec.left_hand:
        return plain
    plain.nodes = [replace(node, type=_OTHER_RULE.get(node.type, node.type)) for node in plain.nodes]
    return plain.mapped(lambda point: (point[0], -point[1]))


def _reflected(value: Any) -> Any:
    """The same road with left and right, and north and south, exchanged everywhere, so that mirroring brings them back."""
    if isinstance(value, dict):
        swapped = {_swapped_name(key): _reflected(item) for key, item in value.items()}
        if "arms" in swapped or "shape" in swapped or "lanes_in" in swapped:
            swapped = {key: -item if key == "angle" else item for key, item in swapped.items()}
        if "arcs" in swapped:
            swapped["arcs"] = [(-angle, radius) for angle, radius in swapped["arcs"]]
        if "y" in swapped:
            swapped["y"] = -swapped["y"]
        if "shape" in swapped and isinstance(swapped["shape"], tuple | list):
            swapped["shape"] = [(x, -y) for x, y in swapped["shape"]]
        return swapped
    if isinstance(value, tuple | list):
        return [_reflected(item) for item in value]
    return _OTHER_SIDE.get(value, value) if isinstance(value, str) else value


def _swapped_name(name: str) -> str:
    first, _, rest = name.partition("_")
    return f"{_OTHER_PART[first]}_{rest}" if first in _OTHER_PART and rest else name
