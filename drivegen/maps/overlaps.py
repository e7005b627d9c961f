"""Roads that lie on top of one another: lanes that meet, of different edges or of one, where there is no junction.

Two roads that cross need a node, or a bridge. Where a writer forgot both, vehicles drive through one another unseen.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import arc_length, resample
from drivegen.maps.road_graph import for_cars
from drivegen.sumo.net_lanes import lane_shape
from drivegen.sumo.plain import Point

_STEP = 2.0
"""Distance between samples on a lane's centreline [m]."""

_TOUCH = 1.5
"""Centrelines this close share a lane's width [m]. It is above half a step's diagonal, so that no crossing slips through."""

_NEAR_NODE = 60.0
"""Lanes of edges that share a node may lie on one another this close to it [m]: ramps and forks leave at small angles."""

_ROUND = 60.0
"""A lane that comes back to where it was so much earlier [m] has crossed itself."""

_CLEARANCE = 4.0
"""Roads this far above one another cross on a bridge [m]."""

_ONE_BRIDGE = 100.0
"""Places this near to one another, where carriageways cross on different levels, are one bridge [m]."""

_MOST = 5
"""So many pairs are named."""

_MOST_HERE = 50
"""Samples in one cell at most: every two of them are compared, and no network has nearly as many."""

_LONGEST = 1e6
"""A lane is no longer [m]: its samples would fill the memory."""


def overlapping(root: Element, place: str) -> tuple[str, ...]:
    """Of a network's parsed XML: "a and b near (x, y)" of edges whose lanes touch away from every shared node; five at most.

    Only lanes for cars count. Raises UnusableInput, which names `place`, where one of them has no possible shape.
    """
    nodes = {j.get("id", ""): (float(j.get("x", "0")), float(j.get("y", "0"))) for j in root.iter("junction")}
    edges = [e for e in root.iter("edge") if not e.get("function") and e.get("from") and e.get("to")]
    ways = [(e.get("from", ""), e.get("to", "")) for e in edges]
    ends = _joined(ways)
    places: dict[tuple[int, int], Point] = {}
    for a, b, (x, y), apart in _touching(edges, place):
        if apart >= _CLEARANCE:
            continue
        # Two roads from one node to another part some time, however near to one another both nodes are.
        same = ways[a] == ways[b] and all(name in nodes for name in ways[a])
        shared = [nodes[name] for name in (ways[a] if same else ends[a] & ends[b]) if name in nodes]
        near = min(_NEAR_NODE, math.dist(*shared) / 4) if same else _NEAR_NODE
        if (a, b) not in places and all(math.dist((x, y), node) > near for node in shared):
            places[a, b] = (x, y)
    places |= {(i, i): at for i, edge in enumerate(edges) if (at := _crosses_itself(edge, place)) is not None}
    names = [edge.get("id", "") for edge in edges]
    lines = [f"{names[a]} and {names[b]} near ({x:.0f}, {y:.0f})" for (a, b), (x, y) in sorted(places.items())]
    return tuple(lines[:_MOST])


def bridges(root: Element, place: str) -> int:
    """In how many places of a network one road passes over another; none without heights. Raises as `overlapping` does."""
    edges = [edge for edge in root.iter("edge") if not edge.get("function")]
    if not any(lane.get("shape", "").split(" ", 1)[0].count(",") > 1 for edge in edges for lane in edge.iter("lane")):
        return 0
    above = {(a, b): middle for a, b, middle, apart in _touching(edges, place) if apart >= _CLEARANCE}
    groups: list[list[Point]] = []
    for middle in above.values():
        near = [one for one in groups if any(math.dist(middle, other) < _ONE_BRIDGE for other in one)]
        groups = [one for one in groups if one not in near] + [[middle, *(other for one in near for other in one)]]
    return len(groups)


def _joined(ends: list[tuple[str, str]]) -> list[set[str]]:
    """The nodes at which each edge ends; where it only goes on there (a turn lane begins), those behind as well."""
    beside: defaultdict[str, set[str]] = defaultdict(set)
    for a, b in ends:
        beside[a].add(b)
        beside[b].add(a)
    return [{a, b}.union(*(beside[node] for node in (a, b) if len(beside[node]) == 2)) for a, b in ends]


def _crosses_itself(edge: Element, place: str) -> Point | None:
    """Where a lane for cars of the edge meets itself again after `_ROUND` [m]; None of a ramp, which may pass over itself.

    An edge that ends where it begins may do so near there.
    """
    for lane in edge.iter("lane"):
        if not for_cars(lane) or len({point.partition(",")[2].partition(",")[2] for point in lane.get("shape", "").split()}) > 1:
            continue
        points = resample(_line(lane, place), _STEP)
        apart = round(_ROUND / _STEP)
        ends = (apart, len(points) - apart) if edge.get("from") == edge.get("to") else (0, len(points))
        met = [i for i, j in KDTree(points).query_pairs(_TOUCH) if j - i > apart and i >= ends[0] and j <= ends[1]]
        if met:
            return float(points[min(met)][0]), float(points[min(met)][1])
    return None


def _samples(edge: Element, place: str) -> NDArray[np.float64]:
    """Points (P, 3) on the centrelines of an edge's lanes: x, y and the edge's greatest height, which few networks have."""
    lanes = [lane for lane in edge.iter("lane") if for_cars(lane)]  # the others' shapes nobody has looked at
    flat = np.concatenate([np.zeros((0, 2)), *(resample(_line(lane, place), _STEP) for lane in lanes)])
    height = max((_height(lane, place) for lane in lanes), default=0.0)
    return np.column_stack([flat, np.full(len(flat), height)])


def _line(lane: Element, place: str) -> NDArray[np.float64]:
    line = lane_shape(lane, place)
    if arc_length(line)[-1] > _LONGEST:
        raise UnusableInput(f"{place}: lane {lane.get('id', '')!r} is longer than {_LONGEST / 1000:.0f} km", reason="bad-map")
    return line


def _height(lane: Element, place: str) -> float:
    """A lane's greatest height [m]; 0 where it has none."""
    try:
        heights = [float(point.split(",")[2]) for point in lane.get("shape", "").split() if point.count(",") > 1]
    except ValueError:
        heights = [math.nan]
    if not all(map(math.isfinite, heights)):
        raise UnusableInput(f"{place}: lane {lane.get('id', '')!r} has a height that is no number", reason="bad-map")
    return max(heights, default=0.0)


def _touching(edges: list[Element], place: str) -> Iterator[tuple[int, int, Point, float]]:
    """Pairs of edges with a place where they touch seen from above, and how far one is above the other there [m].

    Points are sorted into cells, and each is compared with its neighbours. Raises UnusableInput where a cell is too full.
    """
    cells: defaultdict[tuple[int, int], list[tuple[int, float, float, float]]] = defaultdict(list)
    for edge, points in enumerate(_samples(element, place) for element in edges):
        for (i, j), (x, y, z) in zip(np.floor(points[:, :2] / _TOUCH).astype(int).tolist(), points.tolist(), strict=True):
            cells[i, j].append((edge, x, y, z))
    for (i, j), here in cells.items():
        if len(here) > _MOST_HERE:
            said = f"{place}: more than {_MOST_HERE} roads lie on one another near ({here[0][1]:.0f}, {here[0][2]:.0f})"
            raise UnusableInput(said, reason="bad-map")
        near = [there for di, dj in ((1, -1), (1, 0), (1, 1), (0, 1)) for there in cells.get((i + di, j + dj), ())]
        pairs = [*combinations(here, 2), *((a, b) for a in here for b in near)]
        for (a, ax, ay, az), (b, bx, by, bz) in pairs:
            if a != b and math.hypot(ax - bx, ay - by) < _TOUCH:
                yield min(a, b), max(a, b), ((ax + bx) / 2, (ay + by) / 2), abs(az - bz)
