"""Roads that lie on top of one another: lanes of different edges that meet where there is no junction.

Two roads that cross need a node. Where a writer forgot it, vehicles drive through one another unseen.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from drivegen.geometry import resample
from drivegen.safe_xml import parse
from drivegen.sumo.plain import Point

_STEP = 2.0
"""Distance between samples on a lane's centreline [m]."""

_TOUCH = 1.5
"""Centrelines this close share a lane's width [m]. It is above half a step's diagonal, so that no crossing slips through."""

_NEAR_NODE = 60.0
"""Lanes of edges that share a node may lie on one another this close to it [m]: ramps and forks leave at small angles."""

_MOST = 5
"""So many pairs are named."""


def overlapping(net: bytes, place: str) -> tuple[str, ...]:
    """Pairs of edges, as "a and b near (x, y)", whose lanes touch away from every node that they share; five at most."""
    root = parse(net, place, root="net")
    nodes = {j.get("id", ""): (float(j.get("x", "0")), float(j.get("y", "0"))) for j in root.iter("junction")}
    edges = [e for e in root.iter("edge") if not e.get("function") and e.get("from") and e.get("to")]
    ends = [(e.get("from", ""), e.get("to", "")) for e in edges]
    found: dict[tuple[int, int], Point] = {}
    for a, b, (x, y) in _touching([_samples(edge) for edge in edges]):
        shared = [nodes[name] for name in set(ends[a]) & set(ends[b]) if name in nodes]
        if (a, b) not in found and all(math.dist((x, y), node) > _NEAR_NODE for node in shared):
            found[a, b] = (x, y)
    names = [edge.get("id", "") for edge in edges]
    told = [f"{names[a]} and {names[b]} near ({x:.0f}, {y:.0f})" for (a, b), (x, y) in sorted(found.items())]
    return tuple(told[:_MOST])


def _samples(edge: Element) -> NDArray[np.float64]:
    """Points (P, 2) on the centrelines of an edge's lanes."""
    lines = [[tuple(map(float, p.split(",")[:2])) for p in lane.get("shape", "").split()] for lane in edge.iter("lane")]
    points = [resample(np.array(line, np.float64), _STEP) for line in lines if len(line) > 1]
    return np.concatenate(points) if points else np.zeros((0, 2))


def _touching(edges: list[NDArray[np.float64]]) -> Iterator[tuple[int, int, Point]]:
    """Pairs of edges with a place where they touch: points are sorted into cells, and each is compared with its neighbours."""
    cells: defaultdict[tuple[int, int], list[tuple[int, float, float]]] = defaultdict(list)
    for edge, points in enumerate(edges):
        for (i, j), (x, y) in zip(np.floor(points / _TOUCH).astype(int).tolist(), points.tolist(), strict=True):
            cells[i, j].append((edge, x, y))
    for (i, j), here in cells.items():
        near = [there for di, dj in ((1, -1), (1, 0), (1, 1), (0, 1)) for there in cells.get((i + di, j + dj), ())]
        pairs = [*combinations(here, 2), *((a, b) for a in here for b in near)]
        for (a, ax, ay), (b, bx, by) in pairs:
            if a != b and math.hypot(ax - bx, ay - by) < _TOUCH:
                yield min(a, b), max(a, b), ((ax + bx) / 2, (ay + by) / 2)
