"""A route and the line that a vehicle follows on it: pieces of lanes joined, lane changes blended, kinks rounded.

The line has a point every metre. A lane change is a shift to the left of both lanes' own lines by a quintic smoothstep
around the place of the change, so it follows the road's bends. Curvature is bounded by repeated [1 2 1] / 4 smoothing
of the points that exceed it, which leaves all others where they are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import wrap_angle
from drivegen.roads import _line
from drivegen.roads.graph import LaneGraph

SPACING = 1.0
"""Distance between points of a route's line [m]."""

SHORTEST_ROUTE = 5.0
"""At a lane drop a route goes on straight at least this far [m]."""


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
        half_width_right: (P,) float32 [m] from the line to the lane's boundary on the right.
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
    half_width_right: NDArray[np.float32]
    length: float
    lane_changes: int
    exit_s: float

    @cached_property
    def lanes(self) -> tuple[int, ...]:
        """The lanes in order of travel."""
        return tuple(piece.lane for piece in self.pieces)

    @cached_property
    def entries(self) -> NDArray[np.intp]:
        """The points at which the line enters another lane."""
        return np.flatnonzero(self.lane[1:] != self.lane[:-1]) + 1


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
    line, heading, piece, room = _line.joined_line(
        lanes, numbers, graph.line.points, graph.line.start, graph.along, graph.half_width, SPACING
    )
    changes, road_map = np.array([p.change for p in pieces], np.int8), graph.map
    lane, shift, turned, limit = _line.layers(lanes, changes, piece, heading, road_map.in_junction, road_map.speed_limit)
    last, length = pieces[-1], (len(line) - 1) * SPACING
    overshoot = last.end - float(graph.length[last.lane])
    return Route(
        pieces=tuple(pieces),
        line=line,
        heading=heading,
        lane=lane,
        shift=shift,
        turned=turned,
        speed_limit=limit,
        half_width_right=room[:, 1],
        length=length,
        lane_changes=sum(p.change != 0 for p in pieces),
        exit_s=max(0.0, length - overshoot) if overshoot > SPACING else np.inf,
    )


def with_limits(route: Route, speed_limit: NDArray[np.float32]) -> Route:
    """`route` under other limits, those (L,) [m/s] of all lanes of its map."""
    return replace(route, speed_limit=speed_limit[route.lane])


def extended(graph: LaneGraph, pieces: Sequence[Piece], reach: float, barred: NDArray[np.bool_]) -> list[Piece]:
    """`pieces` cut, or continued along the straightest successors, to `reach` [m] in all.

    Lanes `barred` (L,) follow one another only. Where the map ends they go straight on; at a lane drop they end early.
    """
    way: list[Piece] = []
    total = 0.0
    for piece in pieces:
        if total >= reach:
            break
        most = piece.begin + reach - total
        way.append(piece if piece.end <= most else replace(piece, end=most))
        total += max(way[-1].end - piece.begin, 0.0)
    rest = min(max(float(graph.length[way[-1].lane]) - way[-1].end, 0.0), max(reach - total, 0.0))
    if rest > 0:  # a matched track may end in the middle of its lane
        way[-1] = replace(way[-1], end=way[-1].end + rest)
    total += rest
    while total < reach:
        last = way[-1].lane
        following = graph.successors[last]
        if not barred[last]:
            following = following[~barred[following]]
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
    return float(_line.abreast(lane, s, other, graph.line.points, graph.line.start, graph.along))
