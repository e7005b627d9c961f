"""Who goes before a target at a junction: the ways that cross or join its own, and how far others on them still are.

Who is on such a way, or on the lanes that lead there, has right of way over the target if the map says so
(`RoadMap.yields_to`). Where it does not know the order of a pair, the other goes first if its way does not have to yield or stop
and the target's does; between equals if it comes from the right, or comes the other way while the target alone turns across. That
last rule is shown to drivers, and nobody is judged by it: real roads often have another order between such equals. Who has a red
or yellow light and has not entered counts for nobody.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, arc_length, interpolate, project, to_vehicle_frame, wrap_angle
from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import Signals, SignalState
from drivegen.roads.gates import first_crossing
from drivegen.roads.graph import LaneGraph, Links
from drivegen.world.observation import PATH_SPACING
from drivegen.world.replay import Replay
from drivegen.world.replay import project as seen_from

UPSTREAM = 80.0
"""Who is farther than this [m] from where ways meet has no right of way yet."""

IN_LANE = 1.75
"""Who is this near to a lane's middle [m] is in it."""

TURNS = 0.35
"""A way that bends by more than this [rad] to the left turns left."""

PASSED = 1.0
"""A front this far [m] beyond a line has passed it."""

_MUST_WAIT = {LaneControl.YIELD: 1, LaneControl.STOP: 2}


@dataclass(frozen=True)
class Way:
    """A way across a junction by which somebody with right of way comes.

    Attributes:
        line: number of the target's line before it. points: (P, 2) [m] of the way.
        entry, goal: [m] along it where its lane begins, and where it meets the target's.
        closed: (T,) bool, whether its light is red or yellow.
    """

    line: int
    points: Floats
    entry: float
    goal: float
    closed: NDArray[np.bool_]

    def distance(
        self, position: NDArray[np.float32], heading: NDArray[np.float32], valid: NDArray[np.bool_], size: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """(T, M) [m] that M boxes (T, M) are from where the ways meet, inf for those who do not come."""
        frame = np.zeros((len(valid), 6, len(size)), np.float32)
        goal = np.full(valid.shape, self.goal, np.float32)
        seen_from(self.points, goal, position, heading, np.zeros_like(position), valid, size, frame)
        along, reach = frame[:, 0], frame[:, 2]
        backs = np.diff(along, axis=0, prepend=along[:1]) < -0.05  # it goes the other way
        backs[1:] &= valid[:-1]
        comes = valid & ~backs & (np.abs(frame[:, 1]) < IN_LANE) & (along > 0) & (along - reach < self.goal + PASSED)
        closed = self.closed[: len(valid)]
        comes[: len(closed)] &= ~closed[:, None] | (along[: len(closed)] + reach[: len(closed)] > self.entry)
        return np.where(comes, np.maximum(self.goal - along - reach, 0), np.inf).astype(np.float32)


def ways_of(graph: LaneGraph, signals: Signals, number: int, lane: int) -> Iterator[Way]:
    """By which somebody comes who goes before a target that wants to take `lane` and what follows behind its line `number`."""
    line, own = graph.map.centreline, _inside(graph, graph.successors, lane)
    for other in np.flatnonzero(graph.map.in_junction & graph.map.for_vehicles).tolist():
        if other in own:
            continue
        for part in own:
            meet, x, y, _, _ = first_crossing(line.points, *line.start[[part, part + 1]], *line.start[[other, other + 1]])
            if meet and has_right_of_way(graph, other, part):
                points, entry = _approach(graph, other)
                closed = np.isin(signals.of_lane(other), (SignalState.RED, SignalState.YELLOW))
                yield Way(number, points, entry, project(points, np.array([x, y]))[0], closed)


def fill_distances(
    distance: NDArray[np.float32], others: Replay, ways: "list[Way]", row: NDArray[np.integer], other: NDArray[np.integer]
) -> None:
    """Fill `distance` (S, T, G, M) for others `other` (E,) of scenes `row` (E,), all of which `ways` hold for."""
    position = np.ascontiguousarray(others.position[row, :, other].swapaxes(0, 1))
    heading = np.ascontiguousarray(others.heading[row, :, other].T)
    valid = np.ascontiguousarray(others.valid[row, :, other].T)
    for way in ways:
        away = way.distance(position, heading, valid, others.size[row, other])
        distance[row, :, way.line, other] = np.minimum(distance[row, :, way.line, other], away.T)


def has_right_of_way(graph: LaneGraph, other: int, lane: int) -> bool:
    """Whether who comes by lane `other` goes before who wants to take `lane`, where the two meet."""
    order = graph.map.yields_to
    if (order == (lane, other)).all(axis=1).any():
        return True
    if (order == (other, lane)).all(axis=1).any():
        return False
    ranks = [_MUST_WAIT.get(LaneControl(graph.map.control[each]), 0) for each in (other, lane)]
    if ranks[0] != ranks[1]:
        return ranks[0] < ranks[1]
    (theirs, after), (mine, later) = (_bearings(graph, each) for each in (other, lane))
    towards = float(wrap_angle(np.asarray(theirs - mine)))
    if abs(towards) > 0.75 * np.pi:
        side = _side_of_oncoming(graph, other, lane)
        across = [side * float(wrap_angle(np.asarray(end - begin))) > TURNS for begin, end in ((theirs, after), (mine, later))]
        return across[1] and not across[0]
    return towards > 0.25 * np.pi


def _side_of_oncoming(graph: LaneGraph, other: int, lane: int) -> float:
    """On which side of who comes by `lane` those pass who come towards it by `other`: 1 left (traffic keeps right), -1 right."""
    first = _inside(graph, graph.predecessors, lane)[-1]
    begin = graph.map.centreline[first][0]
    theirs = graph.map.centreline[_inside(graph, graph.predecessors, other)[-1]][0]
    return float(np.sign(to_vehicle_frame(theirs[None], begin, np.asarray(graph.heading[first, 0]))[0, 1]))


def _inside(graph: LaneGraph, links: Links, lane: int) -> list[int]:
    """A lane and those in the junction that `links` lead on to: SUMO cuts a way where one waits for oncoming traffic."""
    parts = [lane]
    while len(on := [n for n in links[parts[-1]].tolist() if graph.map.in_junction[n] and n not in parts]) == 1:
        parts += on
    return parts


def _bearings(graph: LaneGraph, lane: int) -> tuple[float, float]:
    """Headings [rad] in which the whole way begins and ends that a lane in a junction is a part of."""
    first, last = (_inside(graph, links, lane)[-1] for links in (graph.predecessors, graph.successors))
    return float(graph.heading[first, 0]), float(graph.heading[last, 1])


def _approach(graph: LaneGraph, lane: int) -> tuple[Floats, float]:
    """The way that leads to a lane and over it, a point every metre, and how far along [m] the lane begins."""
    parts, length, first = [graph.map.centreline[lane]], 0.0, lane
    while length < UPSTREAM and len(graph.predecessors[first]):
        first = int(graph.predecessors[first][0])
        parts.insert(0, graph.map.centreline[first])
        length += float(graph.length[first])
    before = np.concatenate([part[:-1] for part in parts[:-1]] + [parts[-1][:1]]).astype(np.float64)
    whole = np.concatenate([before, parts[-1][1:]]).astype(np.float64)
    return interpolate(whole, np.arange(0.0, float(arc_length(whole)[-1]), PATH_SPACING)), float(arc_length(before)[-1])
