"""Make a SUMO network drivable as people drive it: speeds in bends, and lanes as long as their shapes.

SUMO's vehicles brake for speed limits, not for bends: on a lane with one limit they take a hairpin at 50 km/h. So each
lane gets the speed at which its sharpest bend is comfortable. And SUMO counts positions along a lane's stated length:
where the drawn shape is longer or shorter, vehicles that enter the lane seem to jump in speed.
"""

from xml.etree.ElementTree import Element, tostring

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import arc_length, resample
from drivegen.core.safe_xml import parse
from drivegen.sumo.net_lanes import lane_number, lane_shape

COMFORTABLE = 2.5
"""Lateral acceleration [m/s2] that drivers accept in bends: those in a hurry accept half as much again."""

_SLOWEST = 3.0
"""No bend makes a lane slower than this [m/s]."""

_SHORTEST_SPAN = 8.0
"""A turn is spread over at least this distance [m]: corners of the drawn line are rounded by whoever drives it."""

_REACTION = 1.0
"""... and over at least as far as one drives in this time [s], as long as the lane goes on."""

_FASTEST = 50.0
"""... [m/s] where there is no limit."""

_SPACING = 1.0


def with_human_speeds(raw: bytes, place: str) -> bytes:
    """The network `raw` (a .net.xml) with lower limits in bends, and lane lengths measured along the shapes.

    All lanes of an edge get the same length, the mean: SUMO keeps positions when vehicles change lanes.
    Raises UnusableInput for what is no network.
    """
    root = parse(raw, place, root="net")
    for edge in root.iterfind("edge"):
        if edge.get("function") not in ("crossing", "walkingarea"):
            _adapt(edge, place)
    text: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    return text


def _adapt(edge: Element, place: str) -> None:
    lanes = edge.findall("lane")
    shapes = [lane_shape(lane, place) for lane in lanes]
    length = float(np.mean([arc_length(shape)[-1] for shape in shapes])) if lanes else 0.0
    for lane, shape in zip(lanes, shapes, strict=True):
        limit = lane_number(lane, "speed", np.inf, place)
        if (slow := min(limit, bend_speed(shape, limit))) < np.inf:
            lane.set("speed", f"{slow:.2f}")
        lane.set("length", f"{max(length, 0.1):.2f}")


def bend_speed(line: NDArray[np.float64], limit: float) -> float:
    """Speed [m/s] at which the sharpest bend of `line` (P, 2) is comfortable; infinite for a straight line.

    A bend turns by some angle over a span: v = sqrt(a * span / angle), with the lateral acceleration a.
    """
    steps = np.diff(resample(line, _SPACING), axis=0)
    steps = steps[np.hypot(*steps.T) > 0.0]
    reach = min(round(max(_SHORTEST_SPAN, _REACTION * min(limit, _FASTEST)) / _SPACING), len(steps) - 1)
    if reach < 1:
        return np.inf
    course = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    angle = float(np.abs(course[reach:] - course[:-reach]).max())
    span = max(_SHORTEST_SPAN, reach * _SPACING)
    return max(_SLOWEST, float(np.sqrt(COMFORTABLE * span / angle))) if angle > 0 else np.inf
