"""What a SUMO network really is: roads that meet, rings, merges, lanes, speeds, lengths, read from its own XML.

Only lanes that passenger cars may use count, and junctions are counted as a driver sees them: a place where ramps join
or leave is none. It is what a specification is checked against, and what tables about maps are made of.
"""

import heapq
import math
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import TypeVar
from xml.etree.ElementTree import Element

from drivegen.core.errors import UnusableInput
from drivegen.maps.overlaps import bridges

_LOOP = (225.0, 315.0)
"""A way that turns so far to one side is a loop [degrees]."""

Point = tuple[float, float]
T = TypeVar("T", int, float)


@dataclass(frozen=True)
class Structure:
    """A network in numbers.

    Attributes:
        arms: roads that meet at each junction, most first. approach_lanes: lanes of the roads into the largest one, ahead of
            their turn lanes. turns: ways over all junctions, from road to road. signals: junctions with traffic lights.
        roundabouts: roads that meet each declared ring. ring_lanes: most common number of lanes on rings, 0 without.
        merges, diverges: places where edges join into one, or one splits, and nobody has another way to go.
        lane_drops, lane_gains: places where one edge goes on as one of fewer or more lanes.
        lanes, max_lanes, speed: most common (by length) and largest number of lanes per edge, most common limit [m/s].
        length: longest way through [m]. turn: most that a road turns between junctions, left and right added [degrees].
        loops: ways that turn about 270 degrees to one side between junctions, as the loop ramps of a cloverleaf do.
        bridges: places where roads pass over one another without a junction.
        one_way: no road runs both ways. left_hand: traffic keeps left.
        edges: number of edges. size: larger side of the bounding box [m].
        stuck: edges from which no way out is reached, or that no way in reaches.
    """

    arms: tuple[int, ...]
    approach_lanes: tuple[int, ...]
    turns: int
    signals: int
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


@dataclass(frozen=True)
class _Edge:
    id: str
    source: str
    target: str
    lanes: int
    speed: float
    length: float
    shape: tuple[Point, ...]


def measure(root: Element, place: str) -> Structure:
    """The structure of a network's parsed XML; raises UnusableInput where it has no edge for cars."""
    try:
        edges = {edge.id: edge for element in root.iter("edge") if (edge := _edge(element)) is not None}
    except ValueError as error:
        raise UnusableInput(f"{place}: a lane has a number that is none: {error}", reason="bad-map") from None
    if not edges:
        raise UnusableInput(f"{place} has no road that a car may use", reason="no-lanes")
    return _Graph(root, edges).structure()


def _edge(element: Element) -> _Edge | None:
    if element.get("function") or element.get("from") is None or element.get("to") is None:
        return None
    lanes = [lane for lane in element.iter("lane") if _for_cars(lane)]
    if not lanes:
        return None
    shape = tuple(_points(lanes[len(lanes) // 2].get("shape", "")))
    speed, length = (float(lanes[0].get(name, "0")) for name in ("speed", "length"))
    if not shape or not all(map(math.isfinite, (speed, length, *(value for point in shape for value in point)))):
        raise ValueError(f"edge {element.get('id', '')[:40]!r} has no finite shape, speed and length")
    return _Edge(element.get("id", ""), element.get("from", ""), element.get("to", ""), len(lanes), speed, length, shape)


def _for_cars(lane: Element) -> bool:
    allow, disallow = lane.get("allow"), lane.get("disallow", "").split()
    if allow is not None:
        return "passenger" in allow.split() or "all" in allow.split()
    return "passenger" not in disallow and "all" not in disallow


def _points(text: str) -> Iterable[Point]:
    for pair in text.split():
        x, y = pair.split(",")[:2]
        yield float(x), float(y)


class _Graph:
    """Edges with the ways on from each, U-turns left out."""

    def __init__(self, root: Element, edges: dict[str, _Edge]) -> None:
        self.root, self.edges = root, edges
        self.lit = {j.get("id", "") for j in root.iter("junction") if "traffic_light" in j.get("type", "")}
        self.left_hand = root.get("lefthand", "false") in ("true", "1")
        self.rings = [(set(r.get("nodes", "").split()), set(r.get("edges", "").split())) for r in root.iter("roundabout")]
        self.leaving: defaultdict[str, list[str]] = defaultdict(list)
        self.entering: defaultdict[str, list[str]] = defaultdict(list)
        for edge in edges.values():
            self.leaving[edge.source].append(edge.id)
            self.entering[edge.target].append(edge.id)
        self.on, self.back = defaultdict(set), defaultdict(set)  # type: defaultdict[str, set[str]], defaultdict[str, set[str]]
        for link in root.iter("connection"):
            a, b = link.get("from", ""), link.get("to", "")
            if a in edges and b in edges and not self._opposite(a, b):
                self.on[a].add(b)
                self.back[b].add(a)

    def _opposite(self, a: str, b: str) -> bool:
        x, y = self.edges[a], self.edges[b]
        return x.source == y.target and x.target == y.source

    def structure(self) -> Structure:
        edges = list(self.edges.values())
        ring_nodes = {node for nodes, _ in self.rings for node in nodes}
        ring_edges = {edge for _, ids in self.rings for edge in ids if edge in self.edges}
        merges = {e for e in self.edges if self._only(e, self.back, self.on) and self.edges[e].source not in ring_nodes}
        splits = {e for e in self.edges if self._only(e, self.on, self.back) and self.edges[e].target not in ring_nodes}
        plain = ring_nodes | {self.edges[e].source for e in merges} | {self.edges[e].target for e in splits}
        arms = {node: count for node, count in self._arms().items() if count >= 3 and node not in plain}
        steps = [b - a for a, b in self._continuations()]
        points = [p for edge in edges for p in edge.shape]
        return Structure(
            arms=tuple(sorted(arms.values(), reverse=True)),
            approach_lanes=self._approaches(max(sorted(arms), key=lambda node: arms[node])) if arms else (),
            turns=sum(len(self.on[edge]) for node in arms for edge in self.entering[node]),
            signals=len(self.lit & set(arms)),
            roundabouts=tuple(self._ring_arms(nodes, ids) for nodes, ids in self.rings),
            ring_lanes=_mode((self.edges[e].lanes, 1.0) for e in sorted(ring_edges)) if ring_edges else 0,
            merges=len(merges),
            diverges=len(splits),
            lane_drops=sum(step < 0 for step in steps),
            lane_gains=sum(step > 0 for step in steps),
            lanes=_mode((edge.lanes, edge.length) for edge in edges),
            max_lanes=max(edge.lanes for edge in edges),
            speed=_mode((edge.speed, edge.length) for edge in edges),
            length=self._longest_way(),
            turn=max(self._turned(edge) for edge in self.edges),
            loops=sum(self._is_loop(edge) for edge in self.edges),
            bridges=bridges(self.root),
            one_way=not any(self._opposite(a, b) for a in self.edges for b in self.leaving[self.edges[a].target]),
            left_hand=self.left_hand,
            edges=len(edges),
            size=max(max(p[i] for p in points) - min(p[i] for p in points) for i in (0, 1)),
            stuck=tuple(self._stuck()),
        )

    def _approaches(self, node: str) -> tuple[int, ...]:
        """Lanes of the roads into a node; where turn lanes begin on the way, those before."""
        lanes = []
        for edge in self.entering[node]:
            before = [b for b in self.back[edge] if self.on[b] == {edge} and len(self.back[edge]) == 1]
            lanes.append(min([self.edges[edge].lanes, *(self.edges[b].lanes for b in before)]))
        return tuple(lanes)

    def _only(self, edge: str, towards: dict[str, set[str]], away: dict[str, set[str]]) -> bool:
        others = towards.get(edge, set())
        return len(others) >= 2 and all(away.get(other) == {edge} for other in others)

    def _arms(self) -> dict[str, int]:
        """Number of neighbouring nodes of every node: one per road that meets there."""
        beside: dict[str, set[str]] = defaultdict(set)
        for edge in self.edges.values():
            beside[edge.source].add(edge.target)
            beside[edge.target].add(edge.source)
        return {node: len(others) for node, others in beside.items()}

    def _ring_arms(self, nodes: set[str], ids: set[str]) -> int:
        outside = {(e.source, e.target) for e in self.edges.values() if e.id not in ids}
        return len({frozenset(ends) for ends in outside if (ends[0] in nodes) != (ends[1] in nodes)})

    def _continuations(self) -> Iterable[tuple[int, int]]:
        """Lanes before and after every place where one edge goes on as one other."""
        for a, after in sorted(self.on.items()):
            for b in after:
                if len(after) == 1 and self.back[b] == {a}:
                    yield self.edges[a].lanes, self.edges[b].lanes

    def _ends(self) -> tuple[list[str], list[str]]:
        """Edges that begin and edges that end at the border of the network."""
        into = [e for e in self.edges if all(self._opposite(i, e) for i in self.entering[self.edges[e].source])]
        out = [e for e in self.edges if all(self._opposite(e, o) for o in self.leaving[self.edges[e].target])]
        return into, out

    def _stuck(self) -> list[str]:
        into, out = self._ends()
        reached, leads = _flood(into, self.on), _flood(out, self.back)
        return [e for e in self.edges if (into and e not in reached) or (out and e not in leads)]

    def _longest_way(self) -> float:
        """The longest of the shortest ways from each way in to each way out; without such ends, the longest edge."""
        into, out = self._ends()
        best = max(edge.length for edge in self.edges.values())
        for start in into:
            cost = {start: self.edges[start].length}
            queue = [(cost[start], start)]
            while queue:
                here, edge = heapq.heappop(queue)
                for following in self.on[edge] if here == cost[edge] else ():
                    there = here + self.edges[following].length
                    if there < cost.get(following, math.inf):
                        cost[following] = there
                        heapq.heappush(queue, (there, following))
            best = max([best, *(cost[e] for e in out if e in cost)])
        return best

    def _turned(self, start: str) -> float:
        """Degrees turned along the edge and all that follows it as its only way on."""
        return sum(map(abs, self._turns(start)))

    def _is_loop(self, start: str) -> bool:
        """Whether a way begins here, and not before, that turns about 270 degrees to one side."""
        if len(self.back[start]) == 1 and all(self.on[before] == {start} for before in self.back[start]):
            return False
        headings = [0.0, *accumulate(self._turns(start))]
        return _LOOP[0] <= max(headings) - min(headings) <= _LOOP[1]

    def _turns(self, start: str) -> list[float]:
        """Turns between the steps of the edge and all that follows it as its only way on [degrees], positive to the left."""
        here, seen = start, {start}
        headings = _headings(self.edges[start].shape)
        while len(self.on[here]) == 1:
            (following,) = self.on[here]
            if len(self.back[following]) != 1 or following in seen:
                break
            # Edges of different width lie beside one another, so their headings are joined, not their points.
            headings += _headings(self.edges[following].shape)
            seen.add(following)
            here = following
        return [math.degrees(math.remainder(b - a, math.tau)) for a, b in pairwise(headings)]


def _headings(line: tuple[Point, ...]) -> list[float]:
    """Headings [rad] of the steps of a line, steps below 3 m merged."""
    apart = [line[0]]
    for point in line[1:]:
        if math.dist(point, apart[-1]) >= 3:
            apart.append(point)
    return [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(apart)]


def _flood(starts: Iterable[str], on: dict[str, set[str]]) -> set[str]:
    seen = set(starts)
    todo = list(seen)
    while todo:
        for following in on.get(todo.pop(), ()):
            if following not in seen:
                seen.add(following)
                todo.append(following)
    return seen


def _mode(pairs: Iterable[tuple[T, float]]) -> T:
    weight: Counter[T] = Counter()
    for value, amount in pairs:
        weight[value] += amount  # type: ignore[assignment]
    return max(sorted(weight), key=lambda value: weight[value])
