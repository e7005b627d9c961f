"""A route and the line that a vehicle follows on it: pieces of lanes joined, lane changes blended, kinks rounded.

The line has a point every metre. A lane change is a shift to the left of both lanes' own lines by a quintic smoothstep
around the place of the change, so it follows the road's bends. Curvature is bounded by repeated [1 2 1] / 4 smoothing
of the points that exceed it, which leaves all others where they are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import wrap_angle
from drivegen.roads.graph import LaneGraph

SPACING = 1.0
"""Distance between points of a route's line [m]."""

SHARPEST = 0.2
"""Kinks are rounded until the line bends no more than this [1/m], a turning circle of 5 m ..."""

MOST_PASSES = 60
"""... or this many smoothing passes are done (a hairpin of two lanes' width needs a sharper bend)."""

SHORTEST_ROUTE = 5.0
"""At a lane drop a route goes on straight at least this far [m]."""

LEAST_HALF_WIDTH = 0.3
"""No room beside the line is reported narrower [m]."""


@dataclass(frozen=True)
class Route:
    """A way over the lane graph with P points, one per SPACING; s = 0 is abreast of the vehicle it was made for.

    Attributes:
        pieces: the stretches of lanes it is made of, in order of travel.
        line: (P, 2) float32 [m].
        heading: (P,) float32 [rad] of the line, continuous (not wrapped).
        lane: (P,) int32 lane under each point; the last one stays where the route has left the map.
        shift: (P,) int8 lanes changed to the left minus to the right until there.
        turned: (P,) float32 [rad] heading change within junctions until there.
        speed_limit: (P,) float32 [m/s], NaN where unknown.
        half_width_left, half_width_right: (P,) float32 [m] from the line to the lane's boundaries.
        length: [m] of the line, (P - 1) * SPACING.
        lane_changes: number of lane changes.
        exit_s: [m] where the line leaves the mapped lanes and goes straight on, inf if it does not.
    """

    pieces: "tuple[Piece, ...]"
    line: NDArray[np.float32]
    heading: NDArray[np.float32]
    lane: NDArray[np.int32]
    shift: NDArray[np.int8]
    turned: NDArray[np.float32]
    speed_limit: NDArray[np.float32]
    half_width_left: NDArray[np.float32]
    half_width_right: NDArray[np.float32]
    length: float
    lane_changes: int
    exit_s: float

    @property
    def lanes(self) -> tuple[int, ...]:
        """The lanes in order of travel."""
        return tuple(piece.lane for piece in self.pieces)

    @property
    def leaves_map(self) -> bool:
        """Whether the line goes straight on beyond the end of the map."""
        return bool(np.isfinite(self.exit_s))


@dataclass(frozen=True)
class Piece:
    """A stretch of one lane.

    Attributes:
        lane: its index. begin, end: [m] along it; below 0 and beyond its length the lane is continued straight.
        change: +1 if it is entered by a lane change to the left, -1 to the right, 0 if it is the lane before's successor.
        half_blend: [m] the change is blended over this far before and after; unused for a successor.
    """

    lane: int
    begin: float
    end: float
    change: int
    half_blend: float


def build_route(graph: LaneGraph, pieces: Sequence[Piece]) -> Route:
    """The route over `pieces` (at least one, of positive total length)."""
    lanes = np.array([p.lane for p in pieces], np.int32)
    numbers = np.array([(p.begin, p.end, abs(p.change) * p.half_blend) for p in pieces], np.float64)
    line, heading, piece, room = _line(
        lanes, numbers, graph.line.points, graph.line.start, graph.along, graph.half_width, SPACING
    )
    changes = np.array([p.change for p in pieces])
    lane, last = lanes[piece], pieces[-1]
    overshoot = last.end - float(graph.length[last.lane])
    length = (len(line) - 1) * SPACING
    return Route(
        pieces=tuple(pieces),
        line=line,
        heading=heading,
        lane=lane,
        shift=np.cumsum(changes).astype(np.int8)[piece],
        turned=np.cumsum(np.diff(heading, prepend=heading[:1]) * graph.map.in_junction[lane], dtype=np.float32),
        speed_limit=graph.map.speed_limit[lane],
        half_width_left=room[:, 0],
        half_width_right=room[:, 1],
        length=length,
        lane_changes=int(np.count_nonzero(changes)),
        exit_s=max(0.0, length - overshoot) if overshoot > SPACING else np.inf,
    )


def extended(graph: LaneGraph, pieces: Sequence[Piece], reach: float) -> list[Piece]:
    """`pieces` cut, or continued along the straightest successors, to `reach` [m] in all.

    Where the map ends they go straight on; at a lane drop they end early.
    """
    way: list[Piece] = []
    total = 0.0
    for piece in pieces:
        if total >= reach:
            break
        way.append(replace(piece, end=min(piece.end, piece.begin + reach - total)))
        total += max(way[-1].end - piece.begin, 0.0)
    rest = min(max(float(graph.length[way[-1].lane]) - way[-1].end, 0.0), max(reach - total, 0.0))
    way[-1] = replace(way[-1], end=way[-1].end + rest)  # a matched track may end in the middle of its lane
    total += rest
    while total < reach:
        last = way[-1].lane
        following = graph.successors[last]
        if len(following) == 0:
            if graph.leaves_map[last] or total < SHORTEST_ROUTE:
                way[-1] = replace(way[-1], end=way[-1].end + max(reach - total, SHORTEST_ROUTE))
            break
        turn = np.abs(wrap_angle(graph.heading[following, 1] - graph.heading[last, 1]))
        lane = int(following[np.argmin(turn)])
        way.append(Piece(lane, 0.0, min(float(graph.length[lane]), reach - total), 0, 0.0))
        total += max(way[-1].end, 0.01)
    return way


def abreast(graph: LaneGraph, lane: int, s: float, other: int) -> float:
    """Where along lane `other` [m] the point at `s` of `lane` is nearest."""
    return float(_abreast(lane, s, other, graph.line.points, graph.line.start, graph.along))


@njit(cache=True)
def _abreast(lane, s, other, points, start, along):  # type: ignore[no-untyped-def]
    i, share = _at(s, lane, -1, start, along)
    x = points[i, 0] + share * (points[i + 1, 0] - points[i, 0])
    y = points[i, 1] + share * (points[i + 1, 1] - points[i, 1])
    best, nearest = 0.0, np.inf
    for k in range(start[other], start[other + 1] - 1):
        ex, ey = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        length = max(np.hypot(ex, ey), 1e-6)
        place = min(max(((x - points[k, 0]) * ex + (y - points[k, 1]) * ey) / length, 0.0), length)
        gap = np.hypot(x - points[k, 0] - place * ex / length, y - points[k, 1] - place * ey / length)
        if gap < nearest:
            best, nearest = along[k] + place, gap
    return best


@njit(cache=True)
def _at(s, lane, hint, start, along):  # type: ignore[no-untyped-def]
    """Segment of the lane under `s` (searched on from `hint`) and the share along it, beyond [0, 1] off the ends."""
    i = max(hint, start[lane])
    last = start[lane + 1] - 2
    while i < last and along[i + 1] <= s:
        i += 1
    return i, (s - along[i]) / max(along[i + 1] - along[i], 1e-6)


@njit(cache=True)
def _blend(x):  # type: ignore[no-untyped-def]
    """Quintic smoothstep from 0 to 1."""
    x = min(max(x, 0.0), 1.0)
    return x * x * x * (x * (6.0 * x - 15.0) + 10.0)


@njit(cache=True)
def _joined(lanes, numbers, points, start, along, half_width, spacing):  # type: ignore[no-untyped-def]
    """Points every `spacing` along the pieces as they are, with jumps at lane changes; heading, piece, room of each."""
    ends = np.cumsum(np.maximum(numbers[:, 1] - numbers[:, 0], 0.0))
    count = int(np.floor(ends[-1] / spacing + 1e-6)) + 1
    line, heading = np.empty((count, 2)), np.empty(count)
    piece, room = np.empty(count, np.int32), np.empty((count, 2))
    p, hint = 0, -1
    for k in range(count):
        u = k * spacing
        while p < len(lanes) - 1 and u >= ends[p]:
            p, hint = p + 1, -1
        s = numbers[p, 1] - (ends[p] - u)
        hint, share = _at(s, lanes[p], hint, start, along)
        step_x, step_y = points[hint + 1, 0] - points[hint, 0], points[hint + 1, 1] - points[hint, 1]
        line[k, 0], line[k, 1] = points[hint, 0] + share * step_x, points[hint, 1] + share * step_y
        heading[k], piece[k] = np.arctan2(step_y, step_x), p
        inside = min(max(share, 0.0), 1.0)
        for side in range(2):
            room[k, side] = half_width[hint, side] + inside * (half_width[hint + 1, side] - half_width[hint, side])
    return line, heading, piece, room, ends


@njit(cache=True)
def _blend_changes(lanes, numbers, ends, line, heading, room, points, start, along, spacing):  # type: ignore[no-untyped-def]
    """Shift the points around each lane change so that the line runs on; in place."""
    for p in range(1, len(lanes)):
        half, at = numbers[p, 2], ends[p - 1]
        if half <= 0:
            continue
        i, share = _at(numbers[p - 1, 1], lanes[p - 1], -1, start, along)
        j, other = _at(numbers[p, 0], lanes[p], -1, start, along)
        ex, ey = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
        jump_x = points[j, 0] + other * (points[j + 1, 0] - points[j, 0]) - points[i, 0] - share * ex
        jump_y = points[j, 1] + other * (points[j + 1, 1] - points[j, 1]) - points[i, 1] - share * ey
        size = max(np.hypot(ex, ey), 1e-6)
        forward, left = (jump_x * ex + jump_y * ey) / size, (jump_y * ex - jump_x * ey) / size
        begin = at - min(half, at)  # a change at the very start is blended after it alone
        for k in range(int(np.ceil(begin / spacing)), min(int((begin + 2 * half) / spacing) + 1, len(line))):
            u = k * spacing
            weight = _blend((u - begin) / (2 * half)) - (1.0 if u >= at else 0.0)
            cos, sin = np.cos(heading[k]), np.sin(heading[k])
            line[k, 0] += weight * (forward * cos - left * sin)
            line[k, 1] += weight * (forward * sin + left * cos)
            room[k, 0] -= weight * left
            room[k, 1] += weight * left


@njit(cache=True)
def _bend(line, k):  # type: ignore[no-untyped-def]
    """Curvature [1/m] at an inner point: angle between its segments over their mean length."""
    ax, ay = line[k, 0] - line[k - 1, 0], line[k, 1] - line[k - 1, 1]
    bx, by = line[k + 1, 0] - line[k, 0], line[k + 1, 1] - line[k, 1]
    angle = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    return abs(angle) / max((np.hypot(ax, ay) + np.hypot(bx, by)) / 2, 1e-3)


@njit(cache=True)
def _smooth(line):  # type: ignore[no-untyped-def]
    """Two passes over everything, then over what bends too sharply and its neighbours; the ends stay. In place."""
    count = len(line)
    before = np.empty_like(line)
    sharp = np.ones(count, np.bool_)
    for turn in range(MOST_PASSES):
        if turn >= 2:
            sharp[:] = False
            for k in range(1, count - 1):
                if _bend(line, k) > SHARPEST:
                    sharp[max(k - 2, 0) : k + 3] = True
            if not sharp.any():
                break
        before[:] = line
        for k in range(1, count - 1):
            if sharp[k]:
                for axis in range(2):
                    line[k, axis] = (before[k - 1, axis] + 2 * before[k, axis] + before[k + 1, axis]) / 4


@njit(cache=True)
def _line(lanes, numbers, points, start, along, half_width, spacing):  # type: ignore[no-untyped-def]
    """The finished line (P, 2), its heading (P,), the piece under each point (P,), the room beside it (P, 2)."""
    raw, raw_heading, raw_piece, raw_room, ends = _joined(lanes, numbers, points, start, along, half_width, spacing)
    _blend_changes(lanes, numbers, ends, raw, raw_heading, raw_room, points, start, along, spacing)
    _smooth(raw)
    travelled = np.zeros(len(raw))
    for k in range(1, len(raw)):
        travelled[k] = travelled[k - 1] + np.hypot(raw[k, 0] - raw[k - 1, 0], raw[k, 1] - raw[k - 1, 1])
    count = max(int(np.floor(travelled[-1] / spacing + 1e-6)) + 1, 2)
    line, heading = np.empty((count, 2), np.float32), np.empty(count, np.float32)
    piece, room = np.empty(count, np.int32), np.empty((count, 2), np.float32)
    k = 0
    for q in range(count):
        while k < len(raw) - 2 and travelled[k + 1] <= q * spacing:
            k += 1
        share = (q * spacing - travelled[k]) / max(travelled[k + 1] - travelled[k], 1e-6)
        for axis in range(2):
            line[q, axis] = raw[k, axis] + share * (raw[k + 1, axis] - raw[k, axis])
            room[q, axis] = max(raw_room[k, axis] + share * (raw_room[k + 1, axis] - raw_room[k, axis]), LEAST_HALF_WIDTH)
        piece[q] = raw_piece[k]
    for q in range(count):
        a, b = max(q - 1, 0), min(q + 1, count - 1)
        heading[q] = np.arctan2(line[b, 1] - line[a, 1], line[b, 0] - line[a, 0])
        if q > 0:
            heading[q] = heading[q - 1] + (heading[q] - heading[q - 1] + np.pi) % (2 * np.pi) - np.pi
    return line, heading, piece, room
