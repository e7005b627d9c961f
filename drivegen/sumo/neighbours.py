"""Which lanes of a SUMO network lie side by side, in the same direction (one edge) or the opposite one (two edges)."""

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Polylines, interpolate, project
from drivegen.core.roadmap import NO_LANE, LaneControl, LaneKind
from drivegen.sumo.net_lanes import NetLanes

_GAP = 1.5
"""The carriageways of one road lie within this distance of each other [m]."""

_ABREAST = 1.0
"""Ways across a junction are side by side if they stay at least this far apart at both ends [m]."""


def neighbours(
    lanes: NetLanes, centreline: Polylines, control: NDArray[np.uint8]
) -> tuple[NDArray[np.int32], NDArray[np.bool_], NDArray[np.bool_]]:
    """Neighbour (L, 2), same direction (L, 2) and may change (L, 2), columns left and right.

    In a junction, lanes lie side by side only if they run abreast all the way, and cars change between them only where
    nobody gives way. The opposite neighbour is the nearest lane of the edge that runs back between the same junctions.
    """
    beside = _within_edges(lanes)
    _part_fans(lanes, centreline, beside)
    there = beside != NO_LANE
    free = np.where(lanes.internal, control == LaneControl.FREE, True)
    bicycles = lanes.kind == LaneKind.BIKE
    fits = bicycles[:, None] == bicycles[beside]  # who may use a bus lane is not a question of markings
    may_change = there & lanes.changes & fits & free[:, None] & free[beside]
    same = there.copy()
    for i, j in _opposite(lanes, centreline):
        beside[i, 1 if lanes.lefthand else 0] = j
    return beside, same, may_change


def _within_edges(lanes: NetLanes) -> NDArray[np.int32]:
    beside = np.full((len(lanes), 2), NO_LANE, np.int32)
    row = {pair: i for i, pair in enumerate(lanes.edges)}
    left_first = (-1, 1) if lanes.lefthand else (1, -1)  # lane 0 is the outermost
    for (edge, index), i in row.items():
        for side, step in enumerate(left_first):
            beside[i, side] = row.get((edge, index + step), NO_LANE)
    return beside


def _part_fans(lanes: NetLanes, centreline: Polylines, beside: NDArray[np.int32]) -> None:
    """Take back neighbours among internal lanes that fan out from one lane or run into one."""
    for end in (centreline.points[centreline.start[:-1]], centreline.points[centreline.start[1:] - 1]):
        gap = end[:, None] - end[beside]
        beside[lanes.internal[:, None] & (np.hypot(gap[..., 0], gap[..., 1]) < _ABREAST)] = NO_LANE


def _opposite(lanes: NetLanes, centreline: Polylines) -> list[tuple[int, int]]:
    """Pairs (lane, lane of the opposite direction beside it)."""
    innermost: dict[str, int] = {}
    for i, (edge, index) in enumerate(lanes.edges):
        if not lanes.internal[i] and (edge not in innermost or index > lanes.edges[innermost[edge]][1]):
            innermost[edge] = i
    between: dict[tuple[str, str], list[int]] = defaultdict(list)
    for edge, i in innermost.items():
        between[lanes.ends[edge]].append(i)
    pairs = []
    for (start, end), here in between.items():
        if start == end:
            continue
        for i in here:
            reach = {j: _offset(centreline, i, j) - (lanes.width[i] + lanes.width[j]) / 2 for j in between.get((end, start), [])}
            nearest = min(reach, key=lambda j: reach[j], default=None)
            if nearest is not None and reach[nearest] < _GAP:
                pairs.append((i, nearest))
    return pairs


def _offset(centreline: Polylines, i: int, j: int) -> float:
    """Distance of the middle of lane i from lane j [m]."""
    line = centreline[i].astype(np.float64)
    middle = interpolate(line, np.array([np.hypot(*np.diff(line, axis=0).T).sum() / 2]))[0]
    return abs(project(centreline[j].astype(np.float64), middle)[1])
