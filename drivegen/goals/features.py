"""What a ranker is told of each candidate, in numbers that mean the same on every road.

Places along a route are given relative to where drivers of several habits would be (`goals/forecast.py`) and to where
one may have to stop; distances relative to those needed for stopping, speeds relative to the limit. Nothing tells one
road network from another.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, wrap_angle
from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import DT, TARGET, Scenario, VehicleKind
from drivegen.core.signals import Signals
from drivegen.goals.candidates import Candidates
from drivegen.goals.forecast import Habit, forecast
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.goals.outlook import Outlooks
from drivegen.goals.prior import GAP, shares
from drivegen.goals.traffic import HALTED, Neighbours, Queue
from drivegen.goals.waiting import IN_SIGHT, NEVER, NOBODY, Waiting
from drivegen.roads.line import SPACING, Route
from drivegen.roads.parked import STANDING
from drivegen.roads.reach import Dynamics, speed_caps

FAR = 200.0
"""Nothing farther ahead than this [m] is told apart."""

AROUND = 60.0
"""Vehicles within this distance [m] that go the same way make the flow."""

USUAL_LIMIT = 13.9
"""Taken for the limit where a map has none [m/s]."""

ALLOWED = Dynamics(acceleration=3.0, braking=50.0, lateral=3.0, limit_factor=1.3)
"""What bends and limits allow at most. Braking is as good as unbounded: every cap stays where it is, none is felt before."""

MARKS = (*(habit.name.lower() for habit in Habit), "steady", "leader", "red", "entry")
"""Places on a route that candidates are compared with."""

WAITS = (
    "signal", "opens", "closes", "open_share", "to_line", "queued", "head_gap", "head_speed", "beyond_gap", "beyond_speed",
    "start", "explained", "on_route", "standing_on_route",
)  # fmt: skip
"""What the vehicle waits for on the candidate's route (`goals/waiting.py`) and who is on it."""

OFF_LANE, NO_SHARE = 4.0, 0.1
"""Stand for the offset [m] and the share of the prior where there is no route."""

STARTING = 1.5
"""Each vehicle of a queue drives off this much later than the one before it [s]."""

NAMES = (
    *(f"{kind}_{mark}" for kind in ("to", "near", "at") for mark in MARKS),
    "pace", "acceleration", "end_speed", "speed", "standing", "relative_speed", "keen", "flow",
    "gap", "closing", "red", "entry", "held_up", "ahead_of_flow",
    "lane_changes", "turn", "turns", "offset", "braking", "dead_end", "log_share", "room", "log_mass", "off_lane", "leaves_map",
    *WAITS, "heavy", "edge", "spread", "rules", *(kind.name.lower() for kind in Manoeuvre), "clash", "more_clash",
)  # fmt: skip
"""One name per column."""


@dataclass(frozen=True)
class _Roads:
    """What is known of each route, and in the last row of no route; or, indexed, of the route of each candidate.

    Attributes:
        marks: (R, len(MARKS)) [m] along the route. limit: [m/s]. gap: [m] to the leader. leader: its speed [m/s].
        changes: lane changes. turned: [rad] in junctions. offset: [m] of the vehicle from the line. braking: [m/s2] that
        its bends ask for. length: [m]. share: of its prior. end_speed: [m/s] of a usual driver.
        waits: (R, len(WAITS)) as they are fed to the ranker.
    """

    marks: Floats
    waits: Floats
    limit: Floats
    gap: Floats
    leader: Floats
    changes: Floats
    turned: Floats
    offset: Floats
    braking: Floats
    length: Floats
    share: Floats
    end_speed: Floats

    @classmethod
    def of(cls, scenario: Scenario, signals: Signals, vehicle: int, c: Candidates, seconds: float) -> "_Roads":
        """Those of the routes of `c`."""
        v = scenario.vehicles
        speed, length = max(float(v.speed[vehicle]), 0.0), float(v.size[vehicle, 0])
        reach = max((route.length for route in c.routes), default=0.0)
        around = Neighbours.of(scenario, vehicle).near(v.position[vehicle], reach + 20.0)
        steady = speed * seconds
        rows: list[tuple[float, ...]] = []
        waits: list[tuple[float, ...]] = []
        for route, ahead, offset, share in zip(c.routes, c.ahead, c.offset, shares(c.routes), strict=True):
            queue = Queue.on(route, around)
            drive = forecast(route, speed, length, ahead, queue, signals, round(seconds / DT))
            marks = (*drive.s.tolist(), steady, ahead.leader_gap - GAP, ahead.red_s, ahead.entry_s)
            traffic = (_limit(route), ahead.leader_gap, ahead.leader_speed, route.lane_changes, float(route.turned[-1]))
            way = (abs(float(offset)), _braking(route, speed), route.length, share, float(drive.speed[Habit.USUAL]))
            rows.append((*marks, *traffic, *way))
            waits.append(_waits(Waiting.on(route, speed, length, ahead, queue, signals), speed, queue))
        nowhere = (*[steady] * (len(Habit) + 1), FAR, FAR, FAR)
        rows.append((*nowhere, USUAL_LIMIT, FAR, 0.0, 0.0, 0.0, OFF_LANE, 0.0, FAR, NO_SHARE, speed))
        waits.append(_waits(_NOTHING, speed, Queue(np.zeros(0), np.zeros(0), np.zeros(0))))
        table = np.array(rows).clip(-FAR, 3 * FAR)
        return cls(table[:, : len(MARKS)], np.array(waits), *table[:, len(MARKS) :].T)

    def __getitem__(self, rows: NDArray[np.intp]) -> "_Roads":
        return _Roads(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    def mark(self, name: str) -> Floats:
        """One of the MARKS."""
        return self.marks[:, MARKS.index(name)]


_NOTHING = Waiting(False, 0.0, NEVER, 1.0, np.inf, 0, IN_SIGHT, NOBODY, IN_SIGHT, NOBODY)
"""What a vehicle on no route waits for."""


def features(scenario: Scenario, candidates: Sequence[Candidates]) -> list[NDArray[np.float32]]:
    """(C, len(NAMES)) float32 for each vehicle of the scenario, from the first frame; all within [-3, 3].

    A signal is taken to go on showing its last known state: the one at step 0, unless the scenario gives its programme.
    """
    clashes, signals = _clashes(scenario, candidates), scenario.signals.held()
    return [
        np.column_stack([_of_vehicle(scenario, signals, vehicle, c), clash.clip(0, 3), (clash - clash.min()).clip(0, 3)])
        for vehicle, (c, clash) in enumerate(zip(candidates, clashes, strict=True))
    ]


def _clashes(scenario: Scenario, candidates: Sequence[Candidates]) -> list[NDArray[np.float32]]:
    """(C,) of each vehicle: how many others have goals that exclude the candidate, expected by their prior."""
    together = Outlooks.of(scenario, candidates, np.full(len(candidates), scenario.steps))
    clash = together.exclusions() @ np.concatenate([c.prior for c in candidates])
    return np.split(np.asarray(clash, np.float32), together.start[1:-1])


def _of_vehicle(scenario: Scenario, signals: Signals, vehicle: int, c: Candidates) -> NDArray[np.float32]:
    v = scenario.vehicles
    seconds = max(float(c.step.max()) * DT, DT)
    on_route = c.route >= 0
    along = np.where(on_route, c.s, np.hypot(*(c.position - v.position[vehicle]).T)).astype(np.float64)
    roads = _Roads.of(scenario, signals, vehicle, c, seconds)[np.where(on_route, c.route, len(c.routes))]
    beyond = along[:, None] - roads.marks
    width = 4.0 + 0.08 * along[:, None]
    columns = [
        *np.tanh(beyond / 30.0).T,
        *np.exp(-0.5 * (beyond / width) ** 2).T,
        *np.exp(-0.5 * (beyond / (3 * width)) ** 2).T,
        *_motion(scenario, vehicle, c, along / seconds, roads, seconds),
        *_traffic(max(float(v.speed[vehicle]), 0.0), roads),
        *_way(c, wrap_angle(c.heading - v.heading[vehicle]), along, roads),
        *roads.waits.T,
        *(np.full(len(c), value) for value in _place_in_scene(scenario, vehicle)),
        *(c.manoeuvre == kind for kind in range(len(Manoeuvre))),
    ]
    return np.array(columns).clip(-3, 3).astype(np.float32).T


def _motion(scenario: Scenario, vehicle: int, c: Candidates, pace: Floats, roads: _Roads, seconds: float) -> list[Floats]:
    """What the candidate asks of the vehicle's speed; `pace` (C,) [m/s] is the mean speed on the way."""
    speed = np.full(len(c), max(float(scenario.vehicles.speed[vehicle]), 0.0))
    relative = [pace / roads.limit, 2 * (pace - speed) / seconds, c.speed / roads.limit]
    own = [speed / 15, speed < STANDING, speed / roads.limit, roads.end_speed / roads.limit]
    return [*relative, *own, _flow(scenario, vehicle) / roads.limit]


def _traffic(speed: float, roads: _Roads) -> list[Floats]:
    """What is ahead, relative to the distance for stopping, and how much it holds the vehicle up."""
    need = 5.0 + speed**2 / 5.0
    ahead = [np.minimum(roads.gap, FAR) / (5 + 2 * speed), (roads.leader - speed) / 5]
    stops = [roads.mark("red") / need, roads.mark("entry") / need]
    return [*ahead, *stops, (roads.mark("alone") - roads.mark("usual")) / 50, (roads.mark("usual") - roads.mark("keeping")) / 50]


def _way(c: Candidates, turn: Floats, along: Floats, roads: _Roads) -> list[Floats]:
    """What the way is like, and how much road a candidate stands for."""
    road = [roads.changes, turn, roads.turned, roads.offset, roads.braking / 3, (roads.length - along) / 50]
    mass = [np.log(roads.share) / 2, _room(c, along) / 5, np.log(c.prior + 1e-3) / 2]
    return [*road, *mass, c.route < 0, c.leaves_map]


def _waits(what: Waiting, speed: float, queue: Queue) -> tuple[float, ...]:
    """The WAITS of one route."""
    queued = STARTING * what.queued
    start = what.opens + queued if what.opens > 0 else queued if what.head_speed < HALTED else 0.0
    to_line = min(what.line / (5.0 + speed**2 / 5.0), 3.0)
    signal = (float(what.signal), what.opens / 5, what.closes / 5, what.open_share, to_line)
    head = (what.queued / 4, float(np.tanh(what.head_gap / 15)), what.head_speed / 10)
    beyond = (float(np.tanh(what.beyond_gap / 20)), what.beyond_speed / 10)
    on_route = (len(queue.s) / 4, float((queue.speed < HALTED).sum()) / 4)
    return (*signal, *head, *beyond, min(start, 15.0) / 5, float(what.explained), *on_route)


def _place_in_scene(scenario: Scenario, vehicle: int) -> tuple[float, float, float, float]:
    """Lorry or bus; how far out the vehicle is, as who is beyond it may be unseen; how wide the scene is; whether the map
    says who has to wait where.
    """
    v = scenario.vehicles
    out = np.hypot(*(v.position - v.position[TARGET]).T)
    spread = max(float(out.max()), 1.0)
    heavy, rules = v.kind[vehicle] in (VehicleKind.TRUCK, VehicleKind.BUS), scenario.map.control != LaneControl.UNKNOWN
    return float(heavy), float(out[vehicle]) / spread, spread / 50, float(rules.any())


def _limit(route: Route) -> float:
    limit = float(route.speed_limit[0])
    return USUAL_LIMIT if np.isnan(limit) else max(limit, 3.0)


def _braking(route: Route, speed: float) -> float:
    """Deceleration [m/s2] that the route's bends and limits ask for."""
    return float(_hardest(speed_caps(route, speed, ALLOWED), speed))


@njit(cache=True)
def _hardest(caps, speed):  # type: ignore[no-untyped-def]
    """Hardest braking [m/s2] from `speed` [m/s] to any of the caps (P,), felt from a metre before the first on."""
    hardest = 0.0
    for k in range(len(caps)):
        hardest = max(hardest, (speed**2 - np.float64(caps[k]) ** 2) / (2 * (k * SPACING + 1.0)))
    return hardest


def _flow(scenario: Scenario, vehicle: int) -> float:
    """Mean speed [m/s] of the vehicles around that go the same way, itself included."""
    v = scenario.vehicles
    near = np.hypot(*(v.position - v.position[vehicle]).T) < AROUND
    same = np.abs(wrap_angle(v.heading - v.heading[vehicle])) < np.pi / 4
    return float(v.speed[near & same].mean())


def _room(c: Candidates, along: Floats) -> Floats:
    """Half the distance (C,) [m] between the candidates before and after each on its route."""
    order = np.lexsort((along, c.route))
    s, route = along[order], c.route[order]
    step = np.full(len(c) + 1, 8.0)
    step[1:-1] = np.where(route[1:] == route[:-1], s[1:] - s[:-1], 8.0)
    room = np.empty(len(c))
    room[order] = (step[1:] + step[:-1]) / 2
    return room.clip(0, 15)
