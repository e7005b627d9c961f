"""Random demand for a SUMO network: trips between its fringes along quick routes, as a routes file.

The network starts filled: the first vehicles begin somewhere along their routes, so a warm-up takes seconds, not
minutes. Travel times are scattered anew for every few trips, so that not everybody takes the same way.
"""

import heapq
from collections import defaultdict
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import LaneKind
from drivegen.core.scenario import VehicleKind
from drivegen.sumo.drivers import CYCLED, draw_types
from drivegen.sumo.network import Network

_SHORTEST = 150.0
"""Trips shorter than this [m] are drawn only where the network has no longer ones."""

_SLOWER = 0.6
"""Trips take longer than at the speed limit, by about the inverse of this: signals, bends, other traffic."""

_USUAL_LIMIT = 14.0
"""Of a road that states none [m/s]."""

_TYPES = 40
_TASTES = 4
"""How many times travel times are scattered."""


@dataclass(frozen=True)
class Demand:
    """How much traffic.

    Attributes:
        vehicles: that the traffic begins with; new ones enter at the rate at which these leave.
        exit_speed: motor vehicles leave the network no faster than this [m/s]; where that is slow, the road beyond is full and
            queues spill back.
        seconds: until when new vehicles enter [s].
    """

    vehicles: int
    exit_speed: float
    seconds: float


@dataclass(frozen=True)
class _Edges:
    """E edges that cars may use: names, length [m], limit [m/s], travel time [s], lanes, successors; where trips begin, end."""

    names: list[str]
    length: NDArray[np.float64]
    limit: NDArray[np.float64]
    duration: NDArray[np.float64]
    lanes: NDArray[np.int64]
    onward: list[list[int]]
    sources: NDArray[np.int64]
    sinks: NDArray[np.int64]


def vehicles_at_begin(network: Network, density: float, most: int) -> int:
    """How many vehicles fill the network's roads with `density` vehicles per kilometre of lane; 8 at least."""
    return int(min(most, max(8.0, density * _road(network)[1].sum() / 1000.0)))


def mean_limit(network: Network) -> float:
    """Of a metre of lane [m/s]."""
    road, metres = _road(network)
    limit = network.map.speed_limit[road]
    return float(np.average(np.where(np.isfinite(limit), limit, _USUAL_LIMIT), weights=metres))


def _road(network: Network) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Lanes for cars outside junctions, and the length of each [m]."""
    road = np.flatnonzero((network.map.kind == LaneKind.VEHICLE) & ~network.map.in_junction)
    return road, np.array([np.hypot(*np.diff(network.map.centreline[lane], axis=0).T).sum() for lane in road.tolist()])


def draw_demand(network: Network, demand: Demand, random: np.random.Generator) -> bytes:
    """A SUMO routes file with types, routes and departures. Raises UnusableInput where no trip fits on the network."""
    edges = _edges(network)
    root = Element("routes")
    everybody = draw_types(_TYPES, random, root)
    motorised = [one for one in everybody if one.kind != VehicleKind.CYCLIST]
    routes = _draw_routes(edges, 2 * demand.vehicles, random)
    if not routes:
        raise UnusableInput("the network has no two roads that a trip connects", reason="no-trips")
    rate = _SLOWER * demand.vehicles / float(np.mean([edges.duration[route].sum() for route in routes]))
    later = random.uniform(1.0, demand.seconds, size=int(rate * demand.seconds))
    for i, depart in enumerate([0.0] * demand.vehicles + sorted(later.tolist())):
        route = routes[int(random.integers(len(routes)))]
        open_to = everybody if edges.limit[route].max() <= CYCLED else motorised
        kind = open_to[int(random.integers(len(open_to)))]
        vehicle = SubElement(root, "vehicle", id=str(i), type=kind.name, depart=f"{depart:.1f}")
        vehicle.set("departLane", "best" if depart else "random")
        vehicle.set("departSpeed", "desired")
        if kind.kind != VehicleKind.CYCLIST:
            vehicle.set("arrivalSpeed", f"{demand.exit_speed:.1f}")
        vehicle.set("departPos", "base" if depart else "random_free")
        if not depart:
            vehicle.set("departEdge", "random")
        SubElement(vehicle, "route", edges=" ".join(edges.names[e] for e in route))
    return bytes(tostring(root))


def _edges(network: Network) -> _Edges:
    map_ = network.map
    names = [name.rpartition("_")[0] for name in network.lane_names]
    open_lanes = np.flatnonzero((map_.kind == LaneKind.VEHICLE) & ~map_.in_junction).tolist()
    number: dict[str, int] = {}
    for lane in open_lanes:
        number.setdefault(names[lane], len(number))
    if not number:
        raise UnusableInput("the network has no road for cars", reason="no-trips")
    lengths, limits = np.ones(len(number)), np.ones(len(number))
    lanes = np.zeros(len(number), np.int64)
    for lane in open_lanes:
        e = number[names[lane]]
        lengths[e] = np.hypot(*np.diff(map_.centreline[lane], axis=0).T).sum()
        speed = map_.speed_limit[lane]
        limits[e] = float(speed) if np.isfinite(speed) else _USUAL_LIMIT
        lanes[e] += 1
    onward = _successors(network, names, number)
    into: dict[int, set[int]] = defaultdict(set)
    for e, following in enumerate(onward):
        for f in following:
            into[f].add(e)
    sources = np.array([e for e in range(len(number)) if not into[e]] or range(len(number)), np.int64)
    sinks = np.array([e for e in range(len(number)) if not onward[e]] or range(len(number)), np.int64)
    return _Edges(list(number), lengths, limits, lengths / limits, lanes, onward, sources, sinks)


def _successors(network: Network, names: list[str], number: dict[str, int]) -> list[list[int]]:
    """Edges that follow each edge, ways across junctions skipped, U-turns at the network's rim left out."""
    map_ = network.map
    following: dict[int, list[int]] = defaultdict(list)
    for a, b in map_.links[map_.kind[map_.links].max(-1, initial=0) == LaneKind.VEHICLE].tolist():
        following[a].append(b)
    onward: list[set[int]] = [set() for _ in number]
    ends = {edge: network.edge_ends.get(edge, ("", "")) for edge in number}
    for lane, name in enumerate(names):
        if name not in number or map_.in_junction[lane]:
            continue
        stack, seen = list(following[lane]), set[int]()
        while stack:
            reached = stack.pop()
            if map_.in_junction[reached]:
                stack += following[reached] if reached not in seen else ()
                seen.add(reached)
            elif names[reached] in number and ends[names[reached]] != ends[name][::-1]:
                onward[number[name]].add(number[names[reached]])
    return [sorted(edges) for edges in onward]


def _draw_routes(edges: _Edges, count: int, random: np.random.Generator) -> list[list[int]]:
    tastes = [edges.duration * random.lognormal(0.0, 0.4, size=len(edges.names)) for _ in range(_TASTES)]
    weight = edges.lanes[edges.sources] / edges.lanes[edges.sources].sum()
    trees: dict[tuple[int, int], tuple[NDArray[np.int64], NDArray[np.float64]]] = {}
    routes: list[list[int]] = []
    for _ in range(count):
        key = (int(random.choice(edges.sources, p=weight)), int(random.integers(_TASTES)))
        if key not in trees:
            trees[key] = _tree(edges, key[0], tastes[key[1]])
        before, distance = trees[key]
        ends = edges.sinks[np.isfinite(distance[edges.sinks])]
        far = ends[distance[ends] >= _SHORTEST]
        ends = ends[ends != key[0]]
        if len(far) or len(ends):
            routes.append(_trace(before, int(random.choice(far if len(far) else ends))))
    return routes


def _tree(edges: _Edges, source: int, cost: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Dijkstra: edge before each edge on the quickest way from `source` (-1 none), and distance driven [m] (inf)."""
    before = np.full(len(edges.names), -1, np.int64)
    distance = np.full(len(edges.names), np.inf)
    distance[source] = edges.length[source]
    best = {source: 0.0}
    heap = [(0.0, source)]
    while heap:
        so_far, edge = heapq.heappop(heap)
        if so_far > best[edge]:
            continue
        for following in edges.onward[edge]:
            total = so_far + float(cost[following])
            if total < best.get(following, np.inf):
                best[following], before[following] = total, edge
                distance[following] = distance[edge] + edges.length[following]
                heapq.heappush(heap, (total, following))
    return before, distance


def _trace(before: NDArray[np.int64], end: int) -> list[int]:
    route = [end]
    while (previous := int(before[route[-1]])) >= 0:
        route.append(previous)
    return route[::-1]
