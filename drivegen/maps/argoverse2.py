"""An Argoverse 2 map (any road map of lanes and links) as a SUMO network, geometry kept.

Lanes between which changing is legal become the lanes of one edge, every other lane an edge of its own; nodes are the
places where linked lanes touch. Junction outlines of next to no size keep netconvert from cutting anything off the
lanes, so that every centreline comes back as it was, and coordinates are those of the source (Argoverse 2 city frame).
The source has no right of way, so nothing is regulated. What a SUMO network of such nodes cannot hold is left out: crosswalks,
which lanes lie in junctions, oncoming lanes as neighbours, and that the map is cut where its lanes end.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import NO_LANE, LaneKind, RoadMap
from drivegen.sumo.netconvert import plain_to_net
from drivegen.sumo.plain import Connection, Edge, Lane, Node, PlainNetwork, Point, point_shape

_USERS = {LaneKind.VEHICLE: "", LaneKind.BUS: "bus", LaneKind.BIKE: "bicycle"}
_SPEED = 50 / 3.6
_LEFT, _RIGHT = 0, 1
_PRECISION = 3


def to_network(road_map: RoadMap) -> bytes:
    """The SUMO network of `road_map`, millimetres kept; edge `e<lane id>` is named after its rightmost lane.

    Raises UnusableInput where netconvert refuses it.
    """
    return plain_to_net(to_plain(road_map), precision=_PRECISION)


def to_plain(road_map: RoadMap) -> PlainNetwork:
    """The plain network of `road_map`; see the module."""
    if len(road_map) == 0:
        raise UnusableInput("the map has no lanes", reason="no-lanes")
    places = _Places(road_map)
    groups = [group for chain in _chains(road_map) for group in places.join(chain)]
    nodes: dict[int, Point] = {}
    edges = []
    name = {}
    for group in groups:
        edge_name = f"e{int(road_map.lane_id[group[0]])}"
        name.update({lane: (edge_name, index) for index, lane in enumerate(group)})
        (start, end), line = places.of(group[0]), _absolute(road_map, group[0])
        nodes.setdefault(start, line[0])
        nodes.setdefault(end, line[-1])
        edges.append(_edge(road_map, edge_name, group, f"n{start}", f"n{end}"))
    links = [Connection(name[a][0], name[b][0], name[a][1], name[b][1]) for a, b in road_map.links.tolist()]
    return PlainNetwork(
        nodes=[Node(f"n{i}", x, y, "unregulated", point_shape(x, y), radius=0.0) for i, (x, y) in sorted(nodes.items())],
        edges=edges,
        connections=links,
    )


class _Places:
    """Where lanes begin and end: linked ends are one place, found by union-find."""

    def __init__(self, road_map: RoadMap) -> None:
        self._parent = np.arange(2 * len(road_map))
        for a, b in road_map.links.tolist():
            self._union(2 * a + 1, 2 * b)

    def of(self, lane: int) -> tuple[int, int]:
        """The places where a lane begins and ends."""
        return self._find(2 * lane), self._find(2 * lane + 1)

    def join(self, chain: list[int]) -> list[list[int]]:
        """Let lanes side by side share their ends, unless some road would then begin where it ends."""
        if len(chain) == 1:
            return [chain]
        before = self._parent.copy()
        for a, b in pairwise(chain):
            self._union(2 * a, 2 * b)
            self._union(2 * a + 1, 2 * b + 1)
        if all(self._find(2 * lane) != self._find(2 * lane + 1) for lane in range(len(before) // 2)):
            return [chain]
        self._parent = before
        return [[lane] for lane in chain]

    def _find(self, i: int) -> int:
        while self._parent[i] != i:
            self._parent[i] = self._parent[self._parent[i]]
            i = int(self._parent[i])
        return i

    def _union(self, a: int, b: int) -> None:
        low, high = sorted((self._find(a), self._find(b)))
        self._parent[high] = low


def _chains(road_map: RoadMap) -> list[list[int]]:
    """Lanes side by side from right to left, where changing between them is legal; every lane is in one chain."""
    legal = road_map.may_change & road_map.same_direction & (road_map.neighbour != NO_LANE)
    left_of: dict[int, int] = {}
    for lane in range(len(road_map)):
        left = int(road_map.neighbour[lane, _LEFT])
        if not legal[lane, _LEFT] or road_map.kind[lane] != road_map.kind[left]:
            continue
        # Both lanes must say so, and no lane can stand to the left of two.
        if int(road_map.neighbour[left, _RIGHT]) == lane and legal[left, _RIGHT]:
            left_of[lane] = left
    chains = []
    inner, seen = set(left_of.values()), set[int]()
    for lane in range(len(road_map)):
        if lane in inner or lane in seen:
            continue
        chain = [lane]
        while chain[-1] in left_of and left_of[chain[-1]] not in chain:
            chain.append(left_of[chain[-1]])
        seen.update(chain)
        chains.append(chain)
    return chains + [[lane] for lane in range(len(road_map)) if lane not in seen]


def _edge(road_map: RoadMap, name: str, group: list[int], source: str, target: str) -> Edge:
    limits = [float(v) if np.isfinite(v) else _SPEED for v in road_map.speed_limit[group]]
    lanes = [
        Lane(_width(road_map, lane), _USERS[LaneKind(int(road_map.kind[lane]))], tuple(_absolute(road_map, lane)), limit)
        for lane, limit in zip(group, limits, strict=True)
    ]
    return Edge(name, source, target, len(group), max(limits), 1, lanes[0].shape, "center", per_lane=tuple(lanes))


def _absolute(road_map: RoadMap, lane: int) -> list[Point]:
    """The lane's centreline in the source's frame."""
    line: NDArray[np.float64] = road_map.centreline[lane].astype(np.float64) + road_map.origin
    return [(x, y) for x, y in line.tolist()]


def _width(road_map: RoadMap, lane: int) -> float:
    left, right = road_map.left[lane], road_map.right[lane]
    ends = [np.hypot(*(left[i] - right[i])) for i in (0, -1)]
    return float(np.clip(np.mean(ends), 1.0, 8.0))
