"""What a SUMO network really is: roads that meet, rings, merges, lanes, speeds, lengths, read from its own XML.

Only lanes that passenger cars may use count, and junctions are counted as a driver sees them: a place where ramps join
or leave is none. It is what a specification is checked against, and what tables about maps are made of.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar
from xml.etree.ElementTree import Element

import numpy as np

from drivegen.core.geometry import arc_length, interpolate
from drivegen.layouts.compilers.crossings import NODE_TYPES
from drivegen.maps.overlaps import bridges
from drivegen.maps.road_graph import Edge, Point, RoadGraph, read_graph

T = TypeVar("T", int, float)

_SIDE_BY_SIDE = 0.5
"""A gap below this [m] between the lanes of two directions is none: numbers in a network are rounded."""

_POINT = 1e-9
"""The square of a step [m2] that leads nowhere."""


@dataclass(frozen=True)
class Structure:
    """A network in numbers.

    Attributes:
        arms: roads that meet at each junction, most first. approach_lanes: lanes of the roads into the largest one, ahead of
            their turn lanes. turns: ways over all junctions, from road to road. signals: junctions with traffic lights.
        controls: who goes first at the junctions of `arms` (`Control`, or the network's own word for another rule), sorted.
        roundabouts: roads that meet each declared ring. ring_lanes: most common number of lanes on rings, 0 without.
        merges, diverges: places where edges join into one, or one splits, and nobody has another way to go.
        lane_drops, lane_gains: places where one edge goes on as one of fewer or more lanes.
        lanes, max_lanes, speed: most common (by length) and largest number of lanes per edge, most common limit [m/s].
        length: longest way through [m]. turn: most that a road turns between junctions, left and right added [degrees].
        loops: ways that turn about 270 degrees to one side between junctions, as the loop ramps of a cloverleaf do.
        median: widest gap half way along a road between its two directions [m], 0 where their lanes lie side by side;
            the two ways round a turning place count, too.
        bridges: places where roads pass over one another without a junction.
        one_way: no road runs both ways. left_hand: traffic keeps left.
        edges: number of edges. size: larger side of the bounding box [m].
        stuck: edges from which no way out is reached, or that no way in reaches.
    """

    arms: tuple[int, ...]
    approach_lanes: tuple[int, ...]
    turns: int
    signals: int
    controls: tuple[str, ...]
    roundabouts: tuple[int, ...]
    ring_lanes: int
    merges: int
    diverges: int
    lane_drops: int
    lane_gains: int
    lanes: int
    max_lanes: int
    speed: float
    length: float
    turn: float
    loops: int
    median: float
    bridges: int
    one_way: bool
    left_hand: bool
    edges: int
    size: float
    stuck: tuple[str, ...]

    @property
    def junctions(self) -> int:
        """Number of junctions, rings apart."""
        return len(self.arms)


def measure(root: Element, place: str) -> Structure:
    """The structure of a network's parsed XML; raises UnusableInput where it has no edge for cars."""
    graph = read_graph(root, place)
    edges = list(graph.edges.values())
    ring_nodes = {node for nodes, _ in graph.rings for node in nodes}
    ring_edges = {edge for _, ids in graph.rings for edge in ids if edge in graph.edges}
    merges = {e for e in graph.edges if _only(e, graph.back, graph.on) and graph.edges[e].source not in ring_nodes}
    splits = {e for e in graph.edges if _only(e, graph.on, graph.back) and graph.edges[e].target not in ring_nodes}
    plain = ring_nodes | {graph.edges[e].source for e in merges} | {graph.edges[e].target for e in splits}
    meeting = {node: count for node, count in _arms(graph).items() if count >= 3}
    arms = {node: count for node, count in meeting.items() if node not in plain}
    steps = [b - a for a, b in _continuations(graph)]
    points = [p for edge in edges for p in edge.shape]
    return Structure(
        arms=tuple(sorted(arms.values(), reverse=True)),
        approach_lanes=_approaches(graph, max(sorted(arms), key=lambda node: arms[node])) if arms else (),
        turns=sum(len(graph.on[edge]) for node in arms for edge in graph.entering[node]),
        signals=len(graph.lit & set(meeting)),
        controls=tuple(sorted(_control(graph.types[node]) for node in arms)),
        roundabouts=tuple(_ring_arms(graph, nodes, ids) for nodes, ids in graph.rings),
        ring_lanes=_mode((graph.edges[e].lanes, 1.0) for e in sorted(ring_edges)) if ring_edges else 0,
        merges=len(merges),
        diverges=len(splits),
        lane_drops=sum(step < 0 for step in steps),
        lane_gains=sum(step > 0 for step in steps),
        lanes=_mode((edge.lanes, edge.length) for edge in edges),
        max_lanes=max(edge.lanes for edge in edges),
        speed=_mode((edge.speed, edge.length) for edge in edges),
        length=graph.longest_way(),
        turn=graph.most_turned(),
        loops=graph.loops(),
        median=_median(edges),
        bridges=bridges(root, place),
        one_way=not any(graph.opposite(a, b) for a in graph.edges for b in graph.leaving[graph.edges[a].target]),
        left_hand=graph.left_hand,
        edges=len(edges),
        size=max(max(p[i] for p in points) - min(p[i] for p in points) for i in (0, 1)),
        stuck=tuple(graph.stuck()),
    )


def _control(node_type: str) -> str:
    """Our word for a node type of SUMO."""
    kind = "traffic_light" if node_type.startswith("traffic_light") else node_type
    known = {**{ours: word for word, ours in NODE_TYPES.items()}, "left_before_right": "uncontrolled"}
    return known.get(kind, kind)


def _median(edges: Iterable[Edge]) -> float:
    """The widest gap half way along a road between the inner lanes of its two directions [m]."""
    of = {(edge.source, edge.target): edge for edge in edges}
    pairs = [(edge, of[ends[::-1]]) for ends, edge in of.items() if ends[0] < ends[1] and ends[::-1] in of]
    gaps = [_from_half_way(a.inner, b.inner) - (a.inner_width + b.inner_width) / 2 for a, b in pairs]
    return max((gap for gap in gaps if gap > _SIDE_BY_SIDE), default=0.0)


def _from_half_way(line: Sequence[Point], other: Sequence[Point]) -> float:
    """Distance from half way along a line to the nearest place of another [m]."""
    points, there = np.asarray(line), np.asarray(other)
    middle = interpolate(points, arc_length(points)[-1:] / 2)[0]
    starts, steps = there[:-1], np.diff(there, axis=0)
    share = np.clip(((middle - starts) * steps).sum(-1) / np.maximum((steps**2).sum(-1), _POINT), 0.0, 1.0)
    return float(np.linalg.norm(starts + share[:, None] * steps - middle, axis=-1).min(initial=math.dist(there[0], middle)))


def _approaches(graph: RoadGraph, node: str) -> tuple[int, ...]:
    """Lanes of the roads into a node; where turn lanes begin on the way, those before."""
    lanes = []
    for edge in graph.entering[node]:
        before = [b for b in graph.back[edge] if graph.on[b] == {edge} and len(graph.back[edge]) == 1]
        lanes.append(min([graph.edges[edge].lanes, *(graph.edges[b].lanes for b in before)]))
    return tuple(lanes)


def _only(edge: str, towards: dict[str, set[str]], away: dict[str, set[str]]) -> bool:
    """Whether the edge follows several others (or several follow it) that have no other way to go."""
    others = towards.get(edge, set())
    return len(others) >= 2 and all(away.get(other) == {edge} for other in others)


def _arms(graph: RoadGraph) -> dict[str, int]:
    """Number of neighbouring nodes of every node: one per road that meets there."""
    beside: dict[str, set[str]] = defaultdict(set)
    for edge in graph.edges.values():
        beside[edge.source].add(edge.target)
        beside[edge.target].add(edge.source)
    return {node: len(others) for node, others in beside.items()}


def _ring_arms(graph: RoadGraph, nodes: set[str], ids: set[str]) -> int:
    """Number of roads that meet a ring of these nodes and edges."""
    outside = {(e.source, e.target) for e in graph.edges.values() if e.id not in ids}
    return len({frozenset(ends) for ends in outside if (ends[0] in nodes) != (ends[1] in nodes)})


def _continuations(graph: RoadGraph) -> Iterable[tuple[int, int]]:
    """Lanes before and after every place where one edge goes on as one other."""
    for a, after in sorted(graph.on.items()):
        for b in after:
            if len(after) == 1 and graph.back[b] == {a}:
                yield graph.edges[a].lanes, graph.edges[b].lanes


def _mode(pairs: Iterable[tuple[T, float]]) -> T:
    """The value with the greatest weight, the least of several."""
    weight: Counter[T] = Counter()
    for value, amount in pairs:
        weight[value] += amount  # type: ignore[assignment]
    return max(sorted(weight), key=lambda value: weight[value])
