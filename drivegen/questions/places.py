"""Candidates as places that a model can tell apart: those that are one place to whoever looks are one place of the question.

What a ranking gives a place is shared among its candidates as the usual odds have them, so that everything it can choose is a
goal that the planner can be given. `with_stops` is what else a model is offered: whole candidates, before any is ranked.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import to_vehicle_frame, wrap_angle
from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import Scenario
from drivegen.core.signals import SignalState
from drivegen.goals.candidates import MOST, SETTLE, Candidates
from drivegen.goals.departures import Departures
from drivegen.goals.manoeuvres import Manoeuvre, manoeuvres
from drivegen.goals.prior import GAP
from drivegen.goals.traffic import HALTED, STAND, Neighbours, Queue
from drivegen.questions.ways import passages
from drivegen.roads.frenet import from_frenet
from drivegen.roads.line import SPACING, Route
from drivegen.roads.parked import STANDING

ALONG, SHARE, ASIDE = 2.0, 0.03, 2.0
"""Places are one within so many metres along the road, or this share of the way there, and so many metres across it, ..."""

SAME_HEADING = np.deg2rad(25)
"""... whose headings differ by less than this [rad] ..."""

SAME_SPEED = 1.5
"""... and, where somebody stands in one of them, speeds by less than this [m/s]."""

KERB = 3.0
"""Parking in the lane is an ordinary stop where that is within this distance along the road [m]."""

NO_NEARER = 1.0
"""A place to stop at is added where no candidate stands within this distance [m]."""


@dataclass(frozen=True)
class Place:
    """One place of a question.

    Attributes:
        members: (M,) candidates that are this place, the one that is shown first. slowest, fastest: [m/s] their end speeds.
    """

    members: NDArray[np.intp]
    slowest: float
    fastest: float

    @property
    def shown(self) -> int:
        """The candidate that stands for all."""
        return int(self.members[0])


def each(c: Candidates) -> list[Place]:
    """Every candidate a place of its own."""
    return [Place(np.array([i]), float(c.speed[i]), float(c.speed[i])) for i in range(len(c))]


def gathered(c: Candidates, shown: Departures, words: Sequence[str]) -> list[Place]:
    """The places that the candidates (C,) are, in their order; `words` (C,) say what each does on its way there."""
    groups: list[list[int]] = []
    for i in range(len(c)):
        home = next((group for group in groups if _one_place(c, shown, words, group[0], i)), None)
        if home is None:
            groups.append([i])
        else:
            home.append(i)
    return [_place(c, shown, group) for group in groups]


def _one_place(c: Candidates, shown: Departures, words: Sequence[str], a: int, b: int) -> bool:
    """Whether candidate `b` is where `a` is."""
    if abs(float(wrap_angle(c.heading[a] - c.heading[b]))) > SAME_HEADING or shown.leaves[a] != shown.leaves[b]:
        return False
    along, aside = np.abs(to_vehicle_frame(shown.place[b][None], shown.place[a], c.heading[a])[0])
    way = max(float(shown.way[a]), float(np.hypot(*(c.position[a] - c.position[b]))))
    speeds = float(shown.speed[a]), float(shown.speed[b])
    stands = min(speeds) < STANDING and not shown.leaves[a]
    if aside > ASIDE or (stands and abs(speeds[0] - speeds[1]) > SAME_SPEED):
        return False
    if shown.leaves[a]:  # at one end of the road, whatever it would have done beyond
        return bool(along <= ALONG / 2)
    if Manoeuvre.PARK in c.manoeuvre[[a, b]]:
        return bool(along <= KERB and max(speeds) < STANDING)
    return bool(along <= (max(ALONG, SHARE * way) if words[a] == words[b] else ALONG / 2))


def _place(c: Candidates, shown: Departures, group: list[int]) -> Place:
    """The group, the one in its middle first; one that stands goes before those that creep, who parks is last."""
    members = np.array(group)
    gap = np.hypot(*(shown.place[members] - shown.place[members].mean(0)).T)
    creeps, parks = shown.speed[members] >= STANDING, c.manoeuvre[members] == Manoeuvre.PARK
    members = members[np.lexsort((gap, creeps, parks))]
    speeds = shown.speed[members]
    return Place(members, float(speeds.min()), float(speeds.max()))


def with_stops(scenario: Scenario, vehicle: int, c: Candidates) -> Candidates:
    """The candidates and, at the end, a place to stand at every line and behind every queue of its routes that has none.

    No more than a list may hold (MOST), those of routes with fewer lane changes first; the given ones where nothing is missing.
    """
    added: list[tuple[int, float]] = []
    stands = c.speed < STANDING
    for number, route in enumerate(c.routes):
        on = c.route == number
        if not on.any():
            continue
        nearest, farthest = float(c.s[on].min()), float(c.s[on].max())
        for s in sorted(_stops(scenario, vehicle, route)):
            spot, _ = from_frenet(route, np.array([s]), _offset(c, number, s))
            there = [*c.position[stands], *(from_frenet(c.routes[r], np.array([p]), _offset(c, r, p))[0][0] for r, p in added)]
            near = np.hypot(*(np.array(there).reshape(-1, 2) - spot[0]).T) < NO_NEARER
            if nearest - SPACING <= s <= farthest and len(c) + len(added) < MOST and not near.any():
                added.append((number, s))
    return _joined(c, added) if added else c


def _stops(scenario: Scenario, vehicle: int, route: Route) -> list[float]:
    """Where [m] a vehicle's middle is that stands at a line of the route, or behind its queue with those before it."""
    length = float(scenario.vehicles.size[vehicle, 0])
    waits = [p for p in passages(scenario.map, scenario.signals, route) if p.begin > 0 and p.control != LaneControl.FREE]
    stops = [p.begin - length / 2 - STAND for p in waits if p.state != SignalState.GREEN]
    queue = Queue.on(route, Neighbours.of(scenario, vehicle))
    halted = np.flatnonzero(queue.speed < HALTED)
    if len(halted):
        first = int(halted[0])  # whoever moves before it will stand behind it
        room = float((queue.length[:first] + GAP).sum())
        stops.append(float(queue.s[first] - queue.length[first] / 2) - room - GAP - length / 2)
    return [s for s in stops if s > 0]


def _offset(c: Candidates, number: int, s: float) -> NDArray[np.float64]:
    return np.array([float(c.offset[number]) * np.exp(-s / SETTLE)])


_COLUMNS = tuple(f.name for f in fields(Candidates))[:11]


def _joined(c: Candidates, added: list[tuple[int, float]]) -> Candidates:
    """With candidates that stand at (route, s); each takes half the prior of the candidate nearest to it."""
    rows: dict[str, list[Any]] = {name: [] for name in _COLUMNS}
    prior = c.prior.copy()
    for number, s in added:
        route, d = c.routes[number], _offset(c, number, s)
        position, heading = from_frenet(route, np.array([s]), d)
        nearest = int(np.argmin(np.hypot(*(c.position - position[0]).T)))
        prior[nearest] /= 2
        at = min(int(s / SPACING), len(route.lane) - 1)
        placed = (position[0], wrap_angle(heading)[0], 0.0, number, s, d[0], c.step[0], manoeuvres(route, s, 0.0))
        for name, value in zip(_COLUMNS, (*placed, route.lane[at], s > route.exit_s, prior[nearest]), strict=True):
            rows[name].append(value)
    return replace(c, prior=prior).with_more(**rows)
