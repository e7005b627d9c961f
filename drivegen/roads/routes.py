"""All feasible routes of a vehicle over the lane graph (paper, "Scenario Rollout": path retrieval).

From the lanes that fit the vehicle's pose the search follows successors and legal lane changes as far as the vehicle
can get; each way becomes a smooth line. Where the map ends the line goes straight on.
"""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import wrap_angle
from drivegen.core.scenario import VehicleKind
from drivegen.roads.frenet import from_frenet, to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.grid import LaneHits
from drivegen.roads.line import SPACING, Piece, Route, abreast, build_route, extended
from drivegen.roads.matching import match_route
from drivegen.roads.search import LaneTree, reachable

__all__ = ["SPACING", "Route", "feasible_routes", "from_frenet", "half_blend", "match_route", "start_lanes", "to_frenet"]

ON_LANE = 3.0
"""A vehicle up to this far from a centreline may be on that lane [m] ..."""

ALONG_LANE = np.pi / 3
"""... if its heading differs from the lane's by no more than this [rad]."""

NEAR_LANE = 15.0
"""A vehicle on no lane (driveway, parking) may join one up to this far away [m] ..."""

JOINING = 2 * np.pi / 3
"""... that does not point at it more than this [rad]."""

OFFSET_SCALE = 1.2
"""Lateral offset [m] and ..."""

ANGLE_SCALE = 0.4
"""... heading difference [rad] of one unit of cost of a start lane (squared sum, as of two normal errors)."""

SPREAD = 4.0
"""Start lanes that cost this much more than the best are left out."""

SURELY = 1.0
"""Who may not use bus lanes is on one only if that costs this much less than any other lane."""

MOST_STARTS = 6

CHANGE_SECONDS = 4.0
"""A lane change takes about this long [s], which gives its length ..."""

SHORTEST_CHANGE = 16.0
LONGEST_CHANGE = 80.0
"""... within these bounds [m]."""

LEAST_NEW = 12.0
"""A way by lane change that adds less road than this [m] is no route of its own."""


def half_blend(speed: float) -> float:
    """Half the length of a lane change at `speed` [m/s], in metres."""
    return min(max(CHANGE_SECONDS * speed, SHORTEST_CHANGE), LONGEST_CHANGE) / 2


def feasible_routes(
    graph: LaneGraph,
    position: NDArray[np.floating],
    heading: float,
    speed: float,
    reach: float,
    most_routes: int = 12,
    most_changes: int = 2,
    kind: int = VehicleKind.CAR,
) -> list[Route]:
    """Routes of at least `reach` [m] (shorter only where lanes end at a lane drop) from a pose, the likeliest kind first.

    `position` (2,) [m], `heading` [rad], `speed` [m/s]. Fewer lane changes come first, then better fitting start lanes,
    then less turning; at most `most_routes` with at most `most_changes` lane changes each. Empty if no lane is near.
    Only a bus (`kind`, a VehicleKind) is led onto bus lanes; who is on one already may go on along it or leave it.
    """
    barred = graph.barred(kind)
    starts, costs = start_lanes(graph, position, heading, barred)
    if len(starts) == 0:
        return []
    half = half_blend(speed)
    tree = reachable(graph, starts.lane, starts.s, costs, reach, half, most_changes, barred)
    ways = _distinct([_pieces(graph, tree, int(leaf), reach, half, barred) for leaf in _worthy(graph, tree, reach)])

    def rank(way: list[Piece]) -> tuple[int, float, float]:
        turns = _turns(graph, way)
        return sum(p.change != 0 for p in way), round(_fit(way, starts, costs) + np.abs(turns).sum(), 4), -turns.sum()

    ways.sort(key=rank)
    return [build_route(graph, way) for way in ways[:most_routes]]


def start_lanes(
    graph: LaneGraph, position: NDArray[np.floating], heading: float, barred: NDArray[np.bool_]
) -> tuple[LaneHits, NDArray[np.float64]]:
    """The lanes that a vehicle may be on, and the cost (H,) of each; if it is on none, those that it may join.

    Of lanes `barred` (L,) those that it is surely on, or where no others are near.
    """
    hits = graph.near(position, NEAR_LANE)
    angle = np.abs(wrap_angle(hits.heading - heading)).astype(np.float64)
    fits = (hits.distance <= ON_LANE) & (angle <= ALONG_LANE)
    if not fits.any():
        fits = angle <= JOINING
        if (others := fits & ~barred[hits.lane]).any():
            fits = others
        if fits.any():
            fits &= hits.distance <= hits.distance[fits].min() + ON_LANE
    fits &= ~_behind(graph, hits, fits)
    cost = (hits.distance / OFFSET_SCALE) ** 2 + (angle / ANGLE_SCALE) ** 2
    fits &= cost <= cost[fits].min(initial=np.inf) + SPREAD
    others = fits & ~barred[hits.lane]
    if cost[others].min(initial=np.inf) <= cost[fits].min(initial=np.inf) + SURELY:
        fits = others
    chosen = np.flatnonzero(fits)
    chosen = chosen[np.lexsort((hits.lane[chosen], cost[chosen]))][:MOST_STARTS]
    starts = LaneHits(hits.lane[chosen], hits.s[chosen], hits.d[chosen], hits.heading[chosen], hits.distance[chosen])
    return starts, cost[chosen]


def _behind(graph: LaneGraph, hits: LaneHits, fits: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Hits at a lane's very end whose successors fit too, and then hits at a lane's very start whose predecessor fits."""
    fitting = set(hits.lane[fits].tolist())
    drop = np.zeros(len(hits), np.bool_)
    for i in np.flatnonzero(fits & (hits.s >= graph.length[hits.lane] - 1e-3)):
        drop[i] = any(int(n) in fitting for n in graph.successors[hits.lane[i]])
    fitting -= set(hits.lane[drop].tolist())
    for i in np.flatnonzero(fits & (np.abs(hits.s) < 1e-3)):
        drop[i] = any(int(n) in fitting for n in graph.predecessors[hits.lane[i]])
    return drop


def _worthy(graph: LaneGraph, tree: LaneTree, reach: float) -> NDArray[np.intp]:
    """Leaves that are routes of their own: not lane changes that come back to known road after a few metres."""
    stays = np.minimum(tree.distance + graph.length[tree.lane] - tree.begin, reach) - tree.distance
    return np.flatnonzero(tree.leaf & ((tree.change == 0) | (stays >= LEAST_NEW)))


def _pieces(graph: LaneGraph, tree: LaneTree, leaf: int, reach: float, half: float, barred: NDArray[np.bool_]) -> list[Piece]:
    """The way from the start to `leaf`, continued along the straightest successors up to `reach` [m]."""
    chain = [leaf]
    while tree.parent[chain[-1]] >= 0:
        chain.append(int(tree.parent[chain[-1]]))
    chain.reverse()
    way: list[Piece] = []
    for node, following in zip(chain, [*chain[1:], None], strict=True):
        lane = int(tree.lane[node])
        end = float(graph.length[lane]) if following is None else float(tree.left_at[following])
        change, begin = int(tree.change[node]), float(tree.begin[node])
        if change:
            begin = abreast(graph, way[-1].lane, way[-1].end, lane)
        way.append(Piece(lane, begin, max(end, begin), change, half))
    return extended(graph, way, reach, barred)


def _distinct(ways: list[list[Piece]]) -> list[list[Piece]]:
    """One way for each sequence of lanes."""
    return list({tuple(piece.lane for piece in way): way for way in reversed(ways)}.values())[::-1]


def _fit(way: list[Piece], starts: LaneHits, costs: NDArray[np.float64]) -> float:
    """The cost of the way's start lane."""
    return float(costs[starts.lane == way[0].lane].min())


def _turns(graph: LaneGraph, way: list[Piece]) -> NDArray[np.float32]:
    """Heading change (P,) [rad] of each lane, to the left."""
    lanes = [piece.lane for piece in way]
    return np.asarray(wrap_angle(graph.heading[lanes, 1] - graph.heading[lanes, 0]))
