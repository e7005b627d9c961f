"""The roads of a SUMO network as a graph: edges that cars may use, what follows each, and the ways through it."""

import heapq
import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from xml.etree.ElementTree import Element

from drivegen.core.errors import UnusableInput
from drivegen.sumo.net_lanes import DEFAULT_WIDTH

_LOOP = (225.0, 315.0)
"""A way that turns so far to one side is a loop [degrees]."""

_LONGEST = 1e6
"""A lane is no longer [m]."""

MOST_WAYS_IN = 200
"""A network that is drawn from a specification has fewer."""

Point = tuple[float, float]


@dataclass(frozen=True)
class Edge:
    """A road in one direction: its nodes, lanes for cars, limit [m/s], length [m] and the line of its middle lane [m].

    `inner` is the line of its lane nearest to oncoming traffic [m], `inner_width` that lane's width [m].
    """

    id: str
    source: str
    target: str
    lanes: int
    speed: float
    length: float
    shape: tuple[Point, ...]
    inner: tuple[Point, ...]
    inner_width: float


def read_graph(root: Element, place: str) -> "RoadGraph":
    """The graph of a network's parsed XML; raises UnusableInput where it has no edge for cars, or a number that is none."""
    edges: dict[str, Edge] = {}
    for element in root.iter("edge"):
        try:
            edge = _edge(element)
        except ValueError:
            name = element.get("id", "")[:40]
            said = f"{place}: edge {name!r} has no finite shape, speed and length (0 to {_LONGEST / 1000:.0f} km)"
            raise UnusableInput(said, reason="bad-map") from None
        if edge is not None:
            edges[edge.id] = edge
    if not edges:
        raise UnusableInput(f"{place} has no road that a car may use", reason="no-lanes")
    lanes = [lane for edge in root.iter("edge") if edge.get("function") == "internal" for lane in edge.iter("lane")]
    return RoadGraph(root, edges, {lane.get("id", ""): _length_within(lane, place) for lane in lanes})


def _length_within(lane: Element, place: str) -> float:
    """The length of a lane within a junction [m], which may be none. Raises UnusableInput where it is no length."""
    text = lane.get("length", "0")
    try:
        length = float(text)
    except ValueError:
        length = math.nan
    if not 0 <= length <= _LONGEST:
        name = lane.get("id", "")[:40]
        raise UnusableInput(f"{place}: lane {name!r} within a junction has length={text[:40]!r}", reason="bad-map")
    return length


def _edge(element: Element) -> Edge | None:
    if element.get("function") or element.get("from") is None or element.get("to") is None:
        return None
    lanes = [lane for lane in element.iter("lane") if for_cars(lane)]
    if not lanes:
        return None
    shape, inner = (tuple(_points(lane.get("shape", ""))) for lane in (lanes[len(lanes) // 2], lanes[-1]))
    speed, length = (float(lanes[0].get(name, "0")) for name in ("speed", "length"))
    width = float(lanes[-1].get("width", DEFAULT_WIDTH))
    if not shape or not inner or not all(map(math.isfinite, (speed, width, *(x for point in shape + inner for x in point)))):
        raise ValueError
    if not 0 < length <= _LONGEST:  # the search of the longest way would not end among negative lengths
        raise ValueError
    name, source, target = (element.get(key, "") for key in ("id", "from", "to"))
    return Edge(name, source, target, len(lanes), speed, length, shape, inner, width)


def for_cars(lane: Element) -> bool:
    """Whether passenger cars may use a lane."""
    allow, disallow = lane.get("allow") or None, lane.get("disallow", "").split()  # SUMO takes allow="" for no word
    if allow is not None:
        return "passenger" in allow.split() or "all" in allow.split()
    return "passenger" not in disallow and "all" not in disallow


def _points(text: str) -> Iterable[Point]:
    for pair in text.split():
        x, y = pair.split(",")[:2]
        yield float(x), float(y)


class RoadGraph:
    """Edges with the ways on from each, U-turns left out; `within` are lengths of lanes within junctions by their ids [m]."""

    def __init__(self, root: Element, edges: dict[str, Edge], within: dict[str, float]) -> None:
        self.edges = edges
        self.types = {j.get("id", ""): j.get("type", "") for j in root.iter("junction")}
        self.lit = {j.get("id", "") for j in root.iter("junction") if "traffic_light" in j.get("type", "")}
        self.left_hand = root.get("lefthand", "false") in ("true", "1")
        self.rings = [(set(r.get("nodes", "").split()), set(r.get("edges", "").split())) for r in root.iter("roundabout")]
        self.leaving: defaultdict[str, list[str]] = defaultdict(list)
        self.entering: defaultdict[str, list[str]] = defaultdict(list)
        for edge in edges.values():
            self.leaving[edge.source].append(edge.id)
            self.entering[edge.target].append(edge.id)
        self.on, self.back = defaultdict(set), defaultdict(set)  # type: defaultdict[str, set[str]], defaultdict[str, set[str]]
        self.across: dict[tuple[str, str], float] = {}
        for link in root.iter("connection"):
            a, b = link.get("from", ""), link.get("to", "")
            if a in edges and b in edges and not self.opposite(a, b):
                self.on[a].add(b)
                self.back[b].add(a)
                self.across[a, b] = within.get(link.get("via", ""), 0.0)

    def opposite(self, a: str, b: str) -> bool:
        """Whether one edge leads back where the other comes from."""
        x, y = self.edges[a], self.edges[b]
        return x.source == y.target and x.target == y.source

    def _ends(self) -> tuple[list[str], list[str]]:
        """Edges that begin and edges that end at the border of the network."""
        into = [e for e in self.edges if all(self.opposite(i, e) for i in self.entering[self.edges[e].source])]
        out = [e for e in self.edges if all(self.opposite(e, o) for o in self.leaving[self.edges[e].target])]
        return into, out

    def stuck(self) -> list[str]:
        """Edges from which no way out is reached, or that no way in reaches."""
        into, out = self._ends()
        reached, leads = _flood(into, self.on), _flood(out, self.back)
        return [e for e in self.edges if (into and e not in reached) or (out and e not in leads)]

    def longest_way(self) -> float:
        """The longest of the shortest ways from each way in to each way out; without such ends, the longest edge.

        Of a city only the first `MOST_WAYS_IN` are tried: each takes a search of the whole network. What lies within a junction
        counts where a road only goes on there.
        """
        into, out = self._ends()
        best = max(edge.length for edge in self.edges.values())
        for start in into[:MOST_WAYS_IN]:
            cost = {start: self.edges[start].length}
            queue = [(cost[start], start)]
            while queue:
                here, edge = heapq.heappop(queue)
                for following in self.on[edge] if here == cost[edge] else ():
                    goes_on = len(self.on[edge]) == len(self.back[following]) == 1
                    there = here + self.edges[following].length + self.across[edge, following] * goes_on
                    if there < cost.get(following, math.inf):
                        cost[following] = there
                        heapq.heappush(queue, (there, following))
            best = max([best, *(cost[e] for e in out if e in cost)])
        return best

    def most_turned(self) -> float:
        """Most degrees that one way turns, left and right added, along an edge and all that follows it as its only way on."""
        return max(sum(map(abs, self._turns(chain))) for chain in self._chains)

    def loops(self) -> int:
        """How many ways turn about 270 degrees to one side between the places where ways join or part."""
        turned = [list(accumulate(self._turns(chain), initial=0.0)) for chain in self._chains if not self._follows(chain[0])]
        return sum(_LOOP[0] <= max(headings) - min(headings) <= _LOOP[1] for headings in turned)

    @cached_property
    def _chains(self) -> list[list[str]]:
        """Edges that follow one another as the only way on and back; each edge stands in one. A circle begins anywhere."""
        chains, seen = [], set[str]()
        for start in sorted(self.edges, key=self._follows):
            if start not in seen:
                chains.append(self._chain(start))
                seen.update(chains[-1])
        return chains

    def _follows(self, edge: str) -> bool:
        """Whether the edge only goes on what comes before it."""
        return len(self.back[edge]) == 1 and all(self.on[before] == {edge} for before in self.back[edge])

    def _chain(self, start: str) -> list[str]:
        """The edge and all that follows it as its only way on."""
        chain = {start: None}
        while len(self.on[here := next(reversed(chain))]) == 1:
            (following,) = self.on[here]
            if len(self.back[following]) != 1 or following in chain:
                break
            chain[following] = None
        return list(chain)

    def _turns(self, chain: list[str]) -> list[float]:
        """Turns between the steps of edges that follow one another [degrees], positive to the left."""
        # Edges of different width lie beside one another, so their headings are joined, not their points.
        headings = [heading for edge in chain for heading in _headings(self.edges[edge].shape)]
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
