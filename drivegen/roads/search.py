"""All lanes that a vehicle can reach: a tree over the lane graph, cheapest way first.

Each lane is reached once, by the fewest lane changes and then the shortest way, so the tree has no more leaves than the
map has lanes and its leaves are all distinct ways to drive. A lane change happens as early as its blend allows.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.roads.graph import LaneGraph

MOST_NODES = 512
"""Lanes that a search visits at most."""

CHANGE_COST = 1e4
"""A lane change costs more than any distance [m]."""

HURRY_COST = 0.1
"""What each metre costs that a change happens before its blend has room: prefer to change on the next lane."""


@dataclass(frozen=True)
class LaneTree:
    """M nodes in the order in which they were reached; a parent stands before its children.

    Attributes:
        lane: (M,) int32. parent: (M,) int32, -1 for a start. change: (M,) int32 +1 / -1 entered by a change left / right.
        begin: (M,) [m] along the lane where it is entered. distance: (M,) [m] from the vehicle to there.
        left_at: (M,) [m] along the parent lane where it was left.
        changes: (M,) number of lane changes until there. leaf: (M,) bool no successor was reached through it: a way ends here.
    """

    lane: NDArray[np.int32]
    parent: NDArray[np.int32]
    change: NDArray[np.int32]
    begin: NDArray[np.float64]
    distance: NDArray[np.float64]
    left_at: NDArray[np.float64]
    changes: NDArray[np.int32]
    leaf: NDArray[np.bool_]


def reachable(
    graph: LaneGraph,
    lanes: NDArray[np.int32],
    begins: NDArray[np.floating],
    costs: NDArray[np.floating],
    reach: float,
    half_blend: float,
    most_changes: int,
    barred: NDArray[np.bool_],
) -> LaneTree:
    """The tree from start lanes (S,), entered at `begins` (S,) [m] with `costs` (S,) [m], up to `reach` [m] away.

    Lanes `barred` (L,) are entered from one another only: who starts on one may go on along it, or leave it.
    """
    whole, numbers = _tree(
        lanes, begins.astype(np.float64), costs.astype(np.float64), reach, half_blend, most_changes, graph.length,
        graph.successors.start, graph.successors.lane, graph.change, barred,
    )  # fmt: skip
    leaf = np.ones(len(whole), np.bool_)
    leaf[whole[(whole[:, 1] >= 0) & (whole[:, 2] == 0), 1]] = False
    lane, parent, change, changes = (np.ascontiguousarray(column) for column in whole.T)
    begin, distance, left_at = (np.ascontiguousarray(column) for column in numbers.T)
    return LaneTree(lane, parent, change, begin, distance, left_at, changes, leaf)


@njit(cache=True)
def _push(ints, floats, waiting, lane, parent, change, changes, begin, distance, left_at, cost):  # type: ignore[no-untyped-def]
    """Put a node on the open list of `waiting` nodes, unless that is full; the new number of nodes."""
    if waiting >= len(ints):
        return waiting
    ints[waiting, 0], ints[waiting, 1], ints[waiting, 2], ints[waiting, 3] = lane, parent, change, changes
    floats[waiting, 0], floats[waiting, 1], floats[waiting, 2], floats[waiting, 3] = begin, distance, left_at, cost
    return waiting + 1


@njit(cache=True)
def _tree(lanes, begins, costs, reach, half_blend, most_changes, length, start, successor, change, barred):  # type: ignore[no-untyped-def]
    """Dijkstra's search with a linear scan, as the open list is short.

    Columns: lane, parent, change, changes; begin, distance, left_at.
    """
    ints, floats = np.empty((MOST_NODES * 4, 4), np.int32), np.empty((MOST_NODES * 4, 4))  # floats' last column: cost
    taken_ints, taken_floats = np.empty((MOST_NODES, 4), np.int32), np.empty((MOST_NODES, 4))
    done = np.zeros(len(length), np.bool_)
    waiting, count = 0, 0
    for i in range(len(lanes)):
        waiting = _push(ints, floats, waiting, lanes[i], -1, 0, 0, begins[i], 0.0, 0.0, costs[i])
    while waiting > 0 and count < MOST_NODES:
        best = np.argmin(floats[:waiting, 3])
        waiting -= 1
        taken_ints[count], taken_floats[count] = ints[best], floats[best]
        ints[best], floats[best] = ints[waiting], floats[waiting]
        lane, changes = taken_ints[count, 0], taken_ints[count, 3]
        if done[lane]:
            continue
        done[lane] = True
        begin, entered, cost = taken_floats[count, 0], taken_floats[count, 1], taken_floats[count, 3]
        leaves_at = entered + max(length[lane] - begin, 0.0)
        if leaves_at < reach:
            for i in range(start[lane], start[lane + 1]):
                if barred[successor[i]] and not barred[lane]:
                    continue
                onward = cost + leaves_at - entered
                waiting = _push(ints, floats, waiting, successor[i], count, 0, changes, 0.0, leaves_at, length[lane], onward)
        earliest = half_blend * (1 + 2 * changes)
        at = min(max(earliest, entered), max(leaves_at - 1.0, entered))
        place = begin + at - entered
        beside = cost + at - entered + CHANGE_COST + HURRY_COST * max(earliest - at, 0.0)
        for side in range(2 if changes < most_changes and at < reach else 0):
            other = change[lane, side]
            if other >= 0 and (barred[lane] or not barred[other]):
                abreast = place * length[other] / max(length[lane], 1.0)  # lanes side by side begin and end abreast
                way = 1 - 2 * side
                waiting = _push(ints, floats, waiting, other, count, way, changes + 1, abreast, at, place, beside)
        count += 1
    return taken_ints[:count], taken_floats[:count, :3]
