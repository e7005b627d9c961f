"""Ways along routes in the words of the road: lanes counted from the right, turns by what the road does, not by the picture."""

from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import wrap_angle
from drivegen.core.roadmap import NO_LANE, LaneControl, LaneKind, RoadMap
from drivegen.core.signals import Signals, SignalState
from drivegen.goals.candidates import Candidates
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.roads.line import SPACING, Route

BEARS, TURNS, TURNS_BACK = np.deg2rad((20.0, 50.0, 140.0))
"""Heading change across a junction [rad] from which on a way bears to a side, turns, turns back."""

SIDE = 3.0
"""Headings before and behind a junction are taken so far from it [m]."""

WIDTH = 3.5
"""Of a lane [m], where a vehicle beside its route's line is taken to be lanes away."""

MOST_LANES = 20

STAYS, KEEPS, PARKS = "stays where it is", "keeps its lane", "pulls over and parks"

IN_LANE = (STAYS, KEEPS, PARKS)
"""What a vehicle does, whatever is said of bends, that is still in its own lane at the end."""

_ODD = {Manoeuvre.STAY: STAYS, Manoeuvre.OFF_LANE: "drives off the lanes", Manoeuvre.PARK: PARKS}
_NUMBERS = ("no lane", "one lane", "two lanes", "three lanes", "four lanes")


@dataclass(frozen=True)
class Passage:
    """A route's way across one junction.

    Attributes:
        begin, end: [m] along the route. lane: the first lane in it. way: "straight on", "left", ...
        control: LaneControl before it. state: SignalState now, UNKNOWN where no signal is known.
    """

    begin: float
    end: float
    lane: int
    way: str
    control: int
    state: int


def passages(road: RoadMap, signals: Signals, route: Route) -> list[Passage]:
    """The junctions that a route crosses, nearest first; of one that the vehicle is in, what is left."""
    inside = road.in_junction[route.lane]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    now = dict(zip(signals.lane.tolist(), signals.state[:, 0].tolist(), strict=True))
    crossed = []
    for begin, end in edges.reshape(-1, 2).tolist():
        lane = int(route.lane[begin])
        after = end + round(SIDE / SPACING)
        if after < len(route.heading):
            turn = float(wrap_angle(route.heading[after] - _heading(road, lane, 0)))
        else:  # the route ends before the junction does, or soon behind it
            turn = _across(road, lane)
        word = _turn(turn) + _fork(road, lane)
        control = LaneControl.SIGNAL if lane in now else int(road.control[lane])
        crossed.append(Passage(begin * SPACING, end * SPACING, lane, word, control, now.get(lane, SignalState.UNKNOWN)))
    return crossed


def way_words(road: RoadMap, signals: Signals, c: Candidates) -> list[str]:
    """What each candidate (C,) does on its way, without where it ends."""
    crossed = [passages(road, signals, route) for route in c.routes]
    return [_words(crossed, c, i) for i in range(len(c))]


def _words(crossed: list[list[Passage]], c: Candidates, i: int) -> str:
    kind, number = Manoeuvre(c.manoeuvre[i]), int(c.route[i])
    if kind in _ODD or number < 0:
        return _ODD.get(kind, _ODD[Manoeuvre.OFF_LANE])
    s, moved = float(c.s[i]), lanes_moved(c, i)
    done = [p for p in crossed[number] if p.begin < s]
    ways = [p.way for p in done if p.end <= s]
    inside = [f"{p.way}, still in the junction" for p in done if p.end > s]
    side = "left" if moved > 0 else "right"
    change = f"{_NUMBERS[min(abs(moved), 4)]} to the {side}" if moved else ""
    if not done:
        bend = _bend(c, i)
        return f"changes {change}{bend}" if change else f"{KEEPS}{bend}"
    return ", then ".join([*_counted(ways), *inside]) + (f", changing {change}" if change else "")


def _bend(c: Candidates, i: int) -> str:
    """That the road turns on the way to a candidate, where the map has no junction there."""
    turn = float(wrap_angle(np.array(float(c.heading[i]) - float(c.routes[c.route[i]].heading[0]))))
    return "" if abs(turn) < TURNS else f", round to the {'left' if turn > 0 else 'right'}"


def _counted(ways: list[str]) -> list[str]:
    """The same way across several junctions in a row is said once.

    >>> _counted(["straight on", "straight on", "turns left"])
    ['straight on at two junctions', 'turns left']
    """
    alike = [(way, len(list(same))) for way, same in groupby(ways)]
    numbers = {2: "two", 3: "three", 4: "four"}
    return [way if count == 1 else f"{way} at {numbers.get(count, count)} junctions" for way, count in alike]


def lanes_moved(c: Candidates, i: int) -> int:
    """Lanes to the left minus to the right, from where the vehicle is: it may be beside the lane its route begins on."""
    route = c.routes[c.route[i]]
    at = min(int(float(c.s[i]) / SPACING), len(route.shift) - 1)
    return int(route.shift[at]) - round(float(c.offset[c.route[i]]) / WIDTH)


def lane_words(road: RoadMap, lane: int) -> str:
    """ "lane 2 of 5", "" in a junction, off the lanes and where there is one lane only."""
    if lane == NO_LANE or road.in_junction[lane]:
        return ""
    right, left = _beside(road, lane, 1), _beside(road, lane, 0)
    return f"lane {right + 1} of {right + left + 1}" if right + left else ""


def _beside(road: RoadMap, lane: int, side: int) -> int:
    """How many lanes of its direction are to that side."""
    count = 0
    while count < MOST_LANES and road.same_direction[lane, side] and road.neighbour[lane, side] != NO_LANE:
        lane = int(road.neighbour[lane, side])
        count += road.kind[lane] != LaneKind.BIKE
    return int(count)


def lane_end(road: RoadMap, lane: int, s: float, reach: float) -> float:
    """[m] from `s` along `lane` to where the lane ends and the road goes on beside it; inf beyond `reach` and where none does."""
    way = -s
    while way < reach:
        way += float(np.hypot(*np.diff(road.centreline[lane], axis=0).T).sum())
        onward = road.links[road.links[:, 0] == lane, 1]
        if len(onward) == 0:
            beside = road.neighbour[lane][road.same_direction[lane] & (road.neighbour[lane] != NO_LANE)]
            goes_on = bool(np.isin(beside, road.links[:, 0]).any())
            return way if goes_on and not road.cut[lane, 1] and way < reach else np.inf
        if len(onward) > 1:
            return np.inf
        lane = int(onward[0])
    return np.inf


def _heading(road: RoadMap, lane: int, at: int) -> float:
    """Of a lane's first (0) or last (-1) piece [rad]."""
    line = road.centreline[lane]
    step = (line[1] - line[0]) if at == 0 else (line[-1] - line[-2])
    return float(np.arctan2(step[1], step[0]))


def _across(road: RoadMap, lane: int) -> float:
    """Heading change [rad] from the beginning of `lane` to the end of the junction: it may go on behind a place to wait in."""
    begin = _heading(road, lane, 0)
    for _ in range(MOST_LANES):
        onward = road.links[road.links[:, 0] == lane, 1]
        if len(onward) != 1 or not road.in_junction[onward[0]]:
            break
        lane = int(onward[0])
    return float(wrap_angle(np.array(_heading(road, lane, -1) - begin)))


def _turn(angle: float) -> str:
    size, side = abs(angle), "left" if angle > 0 else "right"
    if size < BEARS:
        return "straight on"
    if size < TURNS:
        return f"bears {side}"
    return f"turns {side}" if size < TURNS_BACK else "turns back"


def _fork(road: RoadMap, lane: int) -> str:
    """Which of the ways that part where `lane` begins it is, where another one would have the same word."""
    lanes_before = road.links[road.links[:, 1] == lane, 0]
    before = int(lanes_before[0]) if len(lanes_before) else NO_LANE
    ways = road.links[road.links[:, 0] == before, 1].tolist()
    alike = [way for way in ways if _turn(_across(road, way)) == _turn(_across(road, lane))]
    if len(alike) < 2:
        return ""
    start, angle = road.centreline[before][-1], _heading(road, before, -1)

    def leftness(way: int) -> tuple[float, int]:
        gap: NDArray[np.float32] = road.centreline[way][-1] - start
        return float(-np.sin(angle) * gap[0] + np.cos(angle) * gap[1]), way

    place = sorted(alike, key=leftness).index(lane)
    return " (right branch)" if place == 0 else " (left branch)" if place == len(alike) - 1 else " (middle branch)"
