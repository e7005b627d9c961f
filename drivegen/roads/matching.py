"""The route that a logged track really followed: Viterbi over lanes, then one line with blends where the log changed lane.

A hidden Markov model as in map matching: the hidden state is the lane, an observation costs its offset and heading
difference, a transition is cheap along links, dearer for a lane change and very dear for anything else, so noise and
the overlapping lanes of a junction are decided by the whole track.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.core.scenario import DT, VehicleKind
from drivegen.roads.frenet import to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.grid import MOST_HITS, _near
from drivegen.roads.line import Piece, Route, build_route, extended

MOST_OFFSET = 4.0
"""A track that is ever farther than this from its route's line [m] ..."""

USUAL_OFFSET = 1.8
"""... or farther than this on average [m] followed no route."""

SEARCH_RADIUS = 5.0
"""Lanes within this distance of a position may be under it [m]."""

LEAST_STEP = 1.5
"""Positions nearer than this to the one before [m] say nothing new."""

OFFSET_SCALE = 1.0
"""Lateral offset [m] and ..."""

ANGLE_SCALE = 0.4
"""... heading difference [rad] of one unit of cost."""

LANE_CHANGE = 6.0
"""Cost of a lane change where it is legal ..."""

ILLEGAL_CHANGE = 10.0
"""... or not, to a lane of the same direction ..."""

LEAP = 40.0
"""... and of going on where no link leads."""

BACKWARDS = 20.0

CHANGE_SECONDS = 2.0
"""Half the time of a lane change [s]."""

SHORTEST_BLEND, LONGEST_BLEND = 8.0, 40.0
"""Bounds of the half blend of a lane change [m]."""


def match_route(
    graph: LaneGraph, positions: Floats, headings: Floats, beyond: float = 30.0, kind: int = VehicleKind.CAR
) -> Route | None:
    """The route of a track: `positions` (T, 2) [m] and `headings` (T,) [rad] of its valid steps.

    It begins abreast of the first position and ends `beyond` [m] after the last one. The track may be on any lane, what lies
    beyond its end leads only a bus (`kind`, a VehicleKind) onto bus lanes. None if the track followed no lanes: nothing near,
    no way along them where nothing lies `beyond`, or a line that it leaves by more than MOST_OFFSET, or USUAL_OFFSET on average.
    """
    rows = _telling(np.ascontiguousarray(positions, np.float64))
    lane, s = _viterbi(
        np.ascontiguousarray(positions[rows], np.float64), np.ascontiguousarray(headings[rows], np.float64), graph.grid.arrays,
        graph.length, graph.successors.start, graph.successors.lane, graph.map.neighbour, graph.map.same_direction, graph.change,
    )  # fmt: skip
    if len(lane) == 0:
        return None
    pieces = _pieces(graph, lane, s, positions[rows], rows * DT)
    if pieces is None:
        return None
    travelled = sum(max(piece.end - piece.begin, 0.0) for piece in pieces)
    if travelled + beyond <= 0.0:
        return None
    route = build_route(graph, extended(graph, pieces, travelled + beyond, graph.barred(kind)))
    offset = np.abs(to_frenet(route, positions)[:, 1])
    return None if offset.max() > MOST_OFFSET or offset.mean() > USUAL_OFFSET else route


def _telling(positions: NDArray[np.float64]) -> NDArray[np.intp]:
    """Steps at least LEAST_STEP apart, the first and the last among them."""
    rows = _thinned(positions, LEAST_STEP)
    if len(rows) > 1 and np.hypot(*(positions[-1] - positions[rows[-1]])) < LEAST_STEP / 2:
        rows = rows[:-1]
    return np.unique(np.append(rows, len(positions) - 1)) if len(rows) > 1 else rows


def _pieces(
    graph: LaneGraph, lane: NDArray[np.int32], s: NDArray[np.float64], positions: Floats, time: Floats
) -> list[Piece] | None:
    """Lanes with the places where they were entered and left; None if the track leaps where no lanes are beside each other."""
    pieces = [Piece(int(lane[0]), float(s[0]), float(s[0]), 0, 0.0)]
    for i in range(1, len(lane)):
        last = pieces[-1]
        if lane[i] == last.lane:
            pieces[-1] = Piece(last.lane, last.begin, max(last.end, float(s[i])), last.change, last.half_blend)
            continue
        between = _links_between(graph, last.lane, int(lane[i]))
        if between is not None:
            pieces[-1] = Piece(last.lane, last.begin, float(graph.length[last.lane]), last.change, last.half_blend)
            pieces += [Piece(n, 0.0, float(graph.length[n]), 0, 0.0) for n in between]
            pieces.append(Piece(int(lane[i]), 0.0, float(s[i]), 0, 0.0))
            continue
        step = float(np.hypot(*(positions[i] - positions[i - 1])))
        speed = step / max(float(time[i] - time[i - 1]), 1e-3)
        begin = float(s[i]) - step / 2
        end = min(last.end + step / 2, float(graph.length[last.lane]) + step / 2)
        side = _side(graph, lane=last.lane, other=int(lane[i]), end=end, begin=begin)
        if side == 0:
            return None
        half = min(max(CHANGE_SECONDS * speed, SHORTEST_BLEND), LONGEST_BLEND)
        pieces[-1] = Piece(last.lane, last.begin, max(end, last.begin), last.change, last.half_blend)
        pieces.append(Piece(int(lane[i]), begin, max(float(s[i]), begin), side, half))
    return pieces


def _links_between(graph: LaneGraph, lane: int, other: int) -> list[int] | None:
    """Lanes between two that follow one another with at most two between; None if no such links lead there."""
    paths: list[list[int]] = [[]]
    for _ in range(3):
        longer = []
        for path in paths:
            following = graph.successors[path[-1] if path else lane]
            if other in following:
                return path
            longer += [[*path, int(n)] for n in following]
        paths = longer
    return None


def _side(graph: LaneGraph, lane: int, other: int, end: float, begin: float) -> int:
    """+1 if `other` at `begin` lies to the left of `lane` at `end`, -1 to the right, 0 if too far for a lane change."""
    place = [_point(graph, lane, end), _point(graph, other, begin)]
    heading = graph.heading[lane, 1] if end > graph.length[lane] / 2 else graph.heading[lane, 0]
    gap = place[1] - place[0]
    left = float(-np.sin(heading) * gap[0] + np.cos(heading) * gap[1])
    if np.hypot(*gap) > 2 * SEARCH_RADIUS:
        return 0
    return 1 if left >= 0 else -1


def _point(graph: LaneGraph, lane: int, s: float) -> NDArray[np.float64]:
    """The point (2,) of a lane's centreline at `s`, its ends beyond them."""
    rows = slice(graph.line.start[lane], graph.line.start[lane + 1])
    along, points = graph.along[rows], graph.line.points[rows]
    return np.array([np.interp(s, along, points[:, 0]), np.interp(s, along, points[:, 1])])


@njit(cache=True)
def _thinned(positions, least):  # type: ignore[no-untyped-def]
    rows = [0]
    for i in range(1, len(positions)):
        gap_x, gap_y = positions[i, 0] - positions[rows[-1], 0], positions[i, 1] - positions[rows[-1], 1]
        if gap_x * gap_x + gap_y * gap_y >= least * least:
            rows.append(i)
    return np.array(rows)


@njit(cache=True)
def _linked(a, b, length, start, successor):  # type: ignore[no-untyped-def]
    """Length of the lanes between lane a and lane b, over at most three links; -1 if those don't lead there."""
    for i in range(start[a], start[a + 1]):
        if successor[i] == b:
            return 0.0
    for i in range(start[a], start[a + 1]):
        for j in range(start[successor[i]], start[successor[i] + 1]):
            if successor[j] == b:
                return length[successor[i]]
    for i in range(start[a], start[a + 1]):
        for j in range(start[successor[i]], start[successor[i] + 1]):
            for k in range(start[successor[j]], start[successor[j] + 1]):
                if successor[k] == b:
                    return length[successor[i]] + length[successor[j]]
    return -1.0


@njit(cache=True)
def _beside(a, b, neighbour, same_direction, change):  # type: ignore[no-untyped-def]
    """Cost of changing from lane a to lane b beside it; inf if it is not beside it."""
    for side in range(2):
        if neighbour[a, side] == b and same_direction[a, side]:
            return LANE_CHANGE if change[a, side] == b else ILLEGAL_CHANGE
    return np.inf


@njit(cache=True)
def _transition(a, s_a, b, s_b, step, length, start, successor, neighbour, same_direction, change):  # type: ignore[no-untyped-def]
    """Cost of being on lane b at s_b a `step` [m] after lane a at s_a."""
    if a == b:
        return BACKWARDS if s_b < s_a - 2.0 else 0.0
    between = _linked(a, b, length, start, successor)
    if between >= 0:
        return 0.5 * abs(max(length[a] - s_a, 0.0) + between + max(s_b, 0.0) - step)
    cost = _beside(a, b, neighbour, same_direction, change)
    for i in range(start[a], start[a + 1]):  # changed while passing on to the next lane
        cost = min(cost, _beside(successor[i], b, neighbour, same_direction, change) + 1.0)
    for side in range(2):
        beside = neighbour[a, side]
        if beside >= 0 and same_direction[a, side] and _linked(beside, b, length, start, successor) == 0.0:
            cost = min(cost, _beside(a, beside, neighbour, same_direction, change) + 1.0)
    return min(cost, LEAP)


@njit(cache=True)
def _viterbi(positions, headings, grid, length, start, successor, neighbour, same_direction, change):  # type: ignore[no-untyped-def]
    """The likeliest lane and place along it for each observation; empty if one has no lane near.

    `grid` are the arrays that `grid._near` takes after the radius.
    """
    count = len(positions)
    lanes, along = np.empty((count, MOST_HITS), np.int32), np.empty((count, MOST_HITS))
    total, back = np.full((count, MOST_HITS), np.inf), np.zeros((count, MOST_HITS), np.int32)
    states = np.zeros(count, np.int32)
    for t in range(count):
        x, y = positions[t]
        near, numbers = _near(x, y, SEARCH_RADIUS, *grid)
        step = 0.0 if t == 0 else np.hypot(x - positions[t - 1, 0], y - positions[t - 1, 1])
        for h in range(len(near)):
            angle = abs((numbers[h, 2] - headings[t] + np.pi) % (2 * np.pi) - np.pi)
            if angle > np.pi / 2:
                continue
            b, s_b, k = near[h], numbers[h, 0], states[t]
            misfit = (numbers[h, 3] / OFFSET_SCALE) ** 2 + (angle / ANGLE_SCALE) ** 2
            lanes[t, k], along[t, k] = b, s_b
            if t == 0:
                total[t, k] = misfit
            for j in range(states[t - 1] if t > 0 else 0):
                a, s_a = lanes[t - 1, j], along[t - 1, j]
                cost = misfit + total[t - 1, j]
                cost += _transition(a, s_a, b, s_b, step, length, start, successor, neighbour, same_direction, change)
                if cost < total[t, k]:
                    total[t, k], back[t, k] = cost, j
            states[t] += 1
        if states[t] == 0:
            return lanes[0, :0], along[0, :0]
    return _backtrack(lanes, along, total, back, states)


@njit(cache=True)
def _backtrack(lanes, along, total, back, states):  # type: ignore[no-untyped-def]
    """The cheapest sequence of states, read from its end."""
    count = len(states)
    chosen, places = np.empty(count, np.int32), np.empty(count)
    k = int(np.argmin(total[count - 1, : states[count - 1]]))
    for t in range(count - 1, -1, -1):
        chosen[t], places[t] = lanes[t, k], along[t, k]
        k = back[t, k]
    return chosen, places
