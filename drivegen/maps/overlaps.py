"""Roads that lie on top of one another: lanes of different edges that meet where there is no junction.

Two roads that cross need a node, or a bridge. Where a writer forgot both, vehicles drive through one another unseen.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import resample
from drivegen.sumo.plain import Point

_STEP = 2.0
"""Distance between samples on a lane's centreline [m]."""

_TOUCH = 1.5
"""Centrelines this close share a lane's width [m]. It is above half a step's diagonal, so that no crossing slips through."""

_NEAR_NODE = 60.0
"""Lanes of edges that share a node may lie on one another this close to it [m]: ramps and forks leave at small angles."""

_CLEARANCE = 4.0
"""Roads this far above one another cross on a bridge [m]."""

_ONE_BRIDGE = 100.0
"""Places this near to one another, where carriageways cross on different levels, are one bridge [m]."""

_MOST = 5
"""So many pairs are named."""


def overlapping(root: Element) -> tuple[str, ...]:
    """Of a network's parsed XML: "a and b near (x, y)" of edges whose lanes touch away from every shared node; five at most."""
    nodes = {j.get("id", ""): (float(j.get("x", "0")), float(j.get("y", "0"))) for j in root.iter("junction")}
    edges = [e for e in root.iter("edge") if not e.get("function") and e.get("from") and e.get("to")]
    ends = _joined([(e.get("from", ""), e.get("to", "")) for e in edges])
    places: dict[tuple[int, int], Point] = {}
    for a, b, (x, y), apart in _touching([_samples(edge) for edge in edges]):
        if apart >= _CLEARANCE:
            continue
        shared = [nodes[name] for name in ends[a] & ends[b] if name in nodes]
        if (a, b) not in places and all(math.dist((x, y), node) > _NEAR_NODE for node in shared):
            places[a, b] = (x, y)
    names = [edge.get("id", "") for edge in edges]
    lines = [f"{names[a]} and {names[b]} near ({x:.0f}, {y:.0f})" for (a, b), (x, y) in sorted(places.items())]
    return tuple(lines[:_MOST])


def bridges(root: Element) -> int:
    """In how many places of a network one road passes over another; none in a network without heights."""
    edges = [edge for edge in root.iter("edge") if not edge.get("function")]
    if not any(lane.get("shape", "").split(" ", 1)[0].count(",") > 1 for edge in edges for lane in edge.iter("lane")):
        return 0
    above = {(a, b): place for a, b, place, apart in _touching([_samples(edge) for edge in edges]) if apart >= _CLEARANCE}
    groups: list[list[Point]] = []
    for place in above.values():
        near = [one for one in groups if any(math.dist(place, other) < _ONE_BRIDGE for other in one)]
        groups = [one for one in groups if one not in near] + [[place, *(other for one in near for other in one)]]
    return len(groups)


def _joined(ends: list[tuple[str, str]]) -> list[set[str]]:
    """The nodes at which each edge ends; where it only goes on there (a turn lane begins), those behind as well."""
    beside: defaultdict[str, set[str]] = defaultdict(set)
    for a, b in ends:
        beside[a].add(b)
        beside[b].add(a)
    return [{a, b}.union(*(beside[node] for node in (a, b) if len(beside[node]) == 2)) for a, b in ends]


def _samples(edge: Element) -> NDArray[np.float64]:
    """Points (P, 3) on the centrelines of an edge's lanes: x, y and the edge's greatest height, which few networks have."""
    shapes = [[tuple(map(float, p.split(","))) for p in lane.get("shape", "").split()] for lane in edge.iter("lane")]
    points = [resample(np.array([p[:2] for p in shape], np.float64), _STEP) for shape in shapes if len(shape) > 1]
    height = max((p[2] for shape in shapes for p in shape if len(p) > 2), default=0.0)
    flat = np.concatenate(points) if points else np.zeros((0, 2))
    return np.column_stack([flat, np.full(len(flat), height)])


def _touching(edges: list[NDArray[np.float64]]) -> Iterator[tuple[int, int, Point, float]]:
    """Pairs of edges with a place where they touch seen from above, and how far one is above the other there [m].

    Points are sorted into cells, and each is compared with its neighbours.
    """
    cells: defaultdict[tuple[int, int], list[tuple[int, float, float, float]]] = defaultdict(list)
    for edge, points in enumerate(edges):
        for (i, j), (x, y, z) in zip(np.floor(points[:, :2] / _TOUCH).astype(int).tolist(), points.tolist(), strict=True):
            cells[i, j].append((edge, x, y, z))
    for (i, j), here in cells.items():
        near = [there for di, dj in ((1, -1), (1, 0), (1, 1), (0, 1)) for there in cells.get((i + di, j + dj), ())]
        pairs = [*combinations(here, 2), *((a, b) for a in here for b in near)]
        for (a, ax, ay, az), (b, bx, by, bz) in pairs:
            if a != b and math.hypot(ax - bx, ay - by) < _TOUCH:
                yield min(a, b), max(a, b), ((ax + bx) / 2, (ay + by) / 2), abs(az - bz)
