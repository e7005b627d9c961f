"""Manoeuvres as goals: of a vehicle's candidates only those that realise what it is to do keep their probability.

What the selector itself gives to those goals is kept beside it (`Choices.natural`): the price in realism of the words.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.asked.offered import HARD, HARDEST, offered, side_of
from drivegen.core.geometry import to_vehicle_frame, wrap_angle
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import DT, TARGET, Scenario
from drivegen.core.signals import SignalState
from drivegen.goals.candidates import NO_ROUTE, Candidates
from drivegen.goals.manoeuvres import Manoeuvre as Way
from drivegen.placement.ways import crossed
from drivegen.roads.frenet import to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import SPACING, Route
from drivegen.rollout.choices import Choices
from drivegen.selectors.base import Selector
from drivegen.words.request import Manoeuvre

SETTLED, ROOM = 0.5, 20.0
"""Who has changed lanes is so near [m] to the middle of the new one, and took at least so far [m] to get there."""

BEHIND = 2.0
"""Who follows somebody that brakes hard stops so far [m] behind it, bumper to bumper."""

ABREAST = 3.0
"""Who is to change lanes has nobody so near [m], bumper to bumper, in the lane that it changes to."""

IN_LANE = 1.6
"""Who is within this of a route's line [m] is in its lane."""

PAST = 8.0
"""Who has overtaken is so far ahead [m], centre to centre."""

ROUND = np.deg2rad(60)
"""Who has turned heads so far [rad] from where it began, so that the goal is not in the middle of the turn."""

OUT_OF_BEND = np.deg2rad(20)
"""Who is out of a bend has less of it [rad] along the half of its own length behind its middle."""

ACROSS = 2.0
"""Who has turned across a way is so far [m] beyond its line."""

CALM = 3.0
"""Sideways acceleration [m/s2] of a calm turn: it gives the speed in the turn. A goal asks for too much of the way before if it
takes more than PACE times that speed on average, for the planner brakes late."""

PACE = 1.2

_EARLIER, _LATER, _SLOWEST = 1.0, 2.0, 4.0
"""A light is green from so much before to so much after [s] a vehicle that keeps its speed, or at least [m/s], gets there."""

TURNS = {Manoeuvre.TURN_LEFT: Way.LEFT, Manoeuvre.TURN_RIGHT: Way.RIGHT, Manoeuvre.TURN_LEFT_ACROSS: Way.LEFT}
"""Manoeuvres that are turns, and the ways of goals that are."""

_DIRECT = {
    Manoeuvre.CHANGE_LEFT: Way.CHANGE_LEFT,
    Manoeuvre.CHANGE_RIGHT: Way.CHANGE_RIGHT,
    Manoeuvre.STOPPED: Way.STAY,
}


@dataclass(frozen=True)
class Duty:
    """What `vehicle` of a scenario (0: the target) is to do, `within` [s] if that is said."""

    vehicle: int
    manoeuvre: Manoeuvre
    within: float | None


@dataclass(frozen=True)
class Ordered:
    """Choices under duties.

    Attributes:
        choices: `used` is zero for goals that do not realise a vehicle's duty. feasible: of each duty, whether a goal does so
            without haste, nobody is in the way at the first frame, and the target has a goal that lets it happen.
        natural: of each duty, the probability that the selector itself gives to the goals that do.
    """

    choices: Choices
    feasible: tuple[bool, ...]
    natural: tuple[float, ...]


def ordered(graph: LaneGraph, choices: Choices, selector: Selector, duties: Sequence[Duty]) -> Ordered:
    """The choices with each duty's vehicle bound to goals that realise it.

    A duty that no goal realises, or none of those that duties before it left to its vehicle, changes nothing.
    """
    there = list(choices.candidates)
    way = keeping(there[TARGET])
    for duty in duties:
        there[duty.vehicle] = offered(choices.scenario, duty.vehicle, duty.manoeuvre, there[duty.vehicle], way)
    natural, used = list(choices.natural), list(choices.used)
    if any(len(a) != len(b) for a, b in zip(there, choices.candidates, strict=True)):
        natural = selector.rank(graph, choices.scenario, there)
        used = [_fitted(u, n) for u, n in zip(used, natural, strict=True)]
    feasible, mass = [], []
    left = [np.ones(len(candidates), np.bool_) for candidates in there]
    for duty in duties:
        calmly = realising(choices.scenario, there, duty)
        realises = calmly if calmly.any() else realising(choices.scenario, there, duty, hastily=True)
        mass.append(float(natural[duty.vehicle][realises].sum()))
        feasible.append(_narrowed(left, duty.vehicle, realises) and bool(calmly.any()) and _has_room(choices.scenario, duty, way))
        if duty.vehicle != TARGET and not any(other.vehicle == TARGET for other in duties):
            feasible[-1] = _narrowed(left, TARGET, _target_lets(there[TARGET], choices.scenario, duty)) and feasible[-1]
    used = [_bound(u, allowed) for u, allowed in zip(used, left, strict=True)]
    return Ordered(Choices(choices.scenario, there, natural, used), tuple(feasible), tuple(mass))


def _narrowed(left: list[NDArray[np.bool_]], vehicle: int, goals: NDArray[np.bool_]) -> bool:
    """Leave to the vehicle only `goals` (C,) of those that are `left` to it; False, and nothing changes, where that is none."""
    both = left[vehicle] & goals
    if both.any():
        left[vehicle] = both
    return bool(both.any())


def realising(scenario: Scenario, candidates: Sequence[Candidates], duty: Duty, *, hastily: bool = False) -> NDArray[np.bool_]:
    """(C,) which candidates of the duty's vehicle realise it.

    `hastily`: also turns for which it would have to brake late, and changes of lane that are not finished.
    """
    own = candidates[duty.vehicle]
    if duty.manoeuvre in _DIRECT:
        changed = hastily | (duty.manoeuvre is Manoeuvre.STOPPED) | ((np.abs(own.d) < SETTLED) & (own.s > ROOM))
        return np.asarray((own.manoeuvre == _DIRECT[duty.manoeuvre]) & changed)
    if duty.manoeuvre in TURNS:
        return _turning(scenario, candidates, duty, hastily)
    if duty.manoeuvre is Manoeuvre.GO_STRAIGHT:
        return _going_straight(scenario, own, duty.vehicle)
    speed = float(scenario.vehicles.speed[duty.vehicle])
    if duty.manoeuvre is Manoeuvre.HARD_BRAKING:
        near = own.s <= speed**2 / (2 * HARD) + SPACING
        return np.asarray(near & (own.speed < 1.0) & np.isin(own.manoeuvre, (Way.KEEP, Way.STOP)))
    ahead = keeping(candidates[TARGET])
    if ahead is None:
        return np.zeros(len(own), np.bool_)
    s, d = to_frenet(ahead, own.position).T
    if duty.manoeuvre is Manoeuvre.CUT_IN:
        way = Way.CHANGE_LEFT if side_of(scenario, duty.vehicle, duty.manoeuvre, ahead) == 1 else Way.CHANGE_RIGHT
        return np.asarray((own.manoeuvre == way) & (np.abs(d) < IN_LANE))
    expected = float(scenario.vehicles.speed[TARGET]) * scenario.horizon * DT
    return np.asarray((s > expected + PAST) & (own.manoeuvre != Way.STAY))  # OVERTAKE


def _turning(scenario: Scenario, candidates: Sequence[Candidates], duty: Duty, hastily: bool) -> NDArray[np.bool_]:
    """(C,) goals beyond the turn, on routes whose lights are green as the vehicle gets there; those across the target's way."""
    own, vehicle = candidates[duty.vehicle], duty.vehicle
    length = float(scenario.vehicles.size[vehicle, 0])
    side = -1.0 if duty.manoeuvre is Manoeuvre.TURN_RIGHT else 1.0
    turned = side * wrap_angle(own.heading - scenario.vehicles.heading[vehicle]) > ROUND
    green = _on_green(scenario, own, vehicle)
    fits = np.equal(own.manoeuvre, TURNS[duty.manoeuvre]) & turned & green & (hastily | _calm(own, length))
    if duty.manoeuvre is not Manoeuvre.TURN_LEFT_ACROSS:
        return np.asarray(fits)
    way = keeping(candidates[TARGET])
    if way is None:
        return np.zeros(len(own), np.bool_)
    begins = to_frenet(way, scenario.vehicles.position[vehicle][None])[0, 1]
    return np.asarray(fits & (-np.sign(begins) * to_frenet(way, own.position)[:, 1] > ACROSS))


def _calm(own: Candidates, length: float) -> NDArray[np.bool_]:
    """(C,) goals of who is `length` [m] long that leave time for the sharpest bend on the way, and lie behind it."""
    calm = np.zeros(len(own), np.bool_)
    for i in np.flatnonzero(own.route != NO_ROUTE).tolist():
        way = own.routes[int(own.route[i])].heading[: int(own.s[i] / SPACING) + 2]
        bend = np.abs(np.diff(way)) / SPACING
        in_time = own.s[i] / (own.step[i] * DT) <= PACE * np.sqrt(CALM / max(float(bend.max(initial=0.0)), 1e-3))
        calm[i] = in_time and abs(way[-1] - way[-1 - min(int(length / 2 / SPACING) + 1, len(way) - 1)]) < OUT_OF_BEND
    return calm


def _going_straight(scenario: Scenario, own: Candidates, vehicle: int) -> NDArray[np.bool_]:
    """(C,) goals in the vehicle's lane, wholly beyond the first junction at which others cross its way, with green lights."""
    across = crossed(scenario.map)
    ends = np.array([end_of_crossing(route, scenario.map, across) for route in own.routes] + [np.inf])  # the last: NO_ROUTE
    beyond = own.s - float(scenario.vehicles.size[vehicle, 0]) / 2 > ends[own.route]
    return np.asarray(beyond & (own.manoeuvre == Way.KEEP) & _on_green(scenario, own, vehicle))


def end_of_crossing(route: Route, road_map: RoadMap, across: NDArray[np.bool_]) -> float:
    """Where on a route [m] the first junction ends that others cross, on lanes `across` (L,) it; inf if there is none.

    Who begins within a junction does not go over it.
    """
    inside = road_map.in_junction[route.lane]
    at = np.flatnonzero(across[route.lane] & (np.cumsum(~inside) > 0))
    out = np.flatnonzero(~inside[at[0] :]) if len(at) else at
    return float(at[0] + out[0]) * SPACING if len(out) else np.inf


def _on_green(scenario: Scenario, own: Candidates, vehicle: int) -> NDArray[np.bool_]:
    """(C,) goals on routes whose lights are green as the vehicle gets there."""
    speed = float(scenario.vehicles.speed[vehicle])
    return np.isin(own.route, [number for number, route in enumerate(own.routes) if _green(scenario, route, speed)])


def _green(scenario: Scenario, route: Route, speed: float) -> bool:
    """Whether no light on the route forbids the way when a vehicle of this speed [m/s] gets there."""
    signals = scenario.signals
    for lane, state in zip(signals.lane.tolist(), signals.state, strict=True):
        along = np.flatnonzero(route.lane == lane)
        if not len(along) or along[0] == 0:  # not on the route, or it stands beyond the line already
            continue
        arrival = along[0] * SPACING / max(speed, _SLOWEST)
        first, last = round(max(arrival - _EARLIER, 0.0) / DT), round((arrival + _LATER) / DT)
        if np.isin(state[first:last], (SignalState.RED, SignalState.YELLOW)).any():
            return False
    return True


def keeping(candidates: Candidates) -> Route | None:
    """The vehicle's first route without a lane change."""
    return next((route for route in candidates.routes if route.lane_changes == 0), None)


def _has_room(scenario: Scenario, duty: Duty, way: Route | None) -> bool:
    """Whether nobody drives beside a vehicle that is to change lanes, on the side that it changes to; `way`: the target's."""
    side = side_of(scenario, duty.vehicle, duty.manoeuvre, way)
    if side is None:
        return True
    vehicles, own = scenario.vehicles, duty.vehicle
    x, y = to_vehicle_frame(vehicles.position, vehicles.position[own], vehicles.heading[own]).T
    least = (vehicles.size[:, 0] + vehicles.size[own, 0]) / 2 + ABREAST
    return not ((side * y > IN_LANE) & (side * y < 3 * IN_LANE) & (np.abs(x) < least)).any()


def _target_lets(own: Candidates, scenario: Scenario, duty: Duty) -> NDArray[np.bool_]:
    """(C,) goals of the target with which the other vehicle's manoeuvre means something: it drives on in its lane."""
    on = np.isin(own.manoeuvre, (Way.KEEP, Way.STOP))
    if duty.manoeuvre in (Manoeuvre.HARD_BRAKING, Manoeuvre.STOPPED):
        ways = [route for route in own.routes if route.lane_changes == 0]
        places = [to_frenet(way, scenario.vehicles.position[duty.vehicle][None])[0] for way in ways]
        ahead = max((s for s, d in places if abs(d) < IN_LANE), default=-np.inf)
        stop = float(scenario.vehicles.speed[duty.vehicle]) ** 2 / (2 * HARDEST)
        lengths = float(scenario.vehicles.size[[TARGET, duty.vehicle], 0].sum()) / 2
        return np.asarray(on & (own.s <= ahead + stop - lengths - BEHIND))
    if duty.manoeuvre is Manoeuvre.OVERTAKE:
        pace = float(scenario.vehicles.speed[TARGET])
        return np.asarray(on & (own.s <= 1.05 * pace * scenario.horizon * DT))
    return on


def _bound(used: NDArray[np.float32], allowed: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Probabilities of the allowed alone; unchanged where all are allowed, equal where the allowed had none."""
    if allowed.all():
        return used
    kept = np.where(allowed, used, 0.0).astype(np.float64)
    kept = kept if kept.sum() > 0 else allowed.astype(np.float64)
    return np.asarray(kept / kept.sum(), np.float32)


def _fitted(used: NDArray[np.float32], natural: NDArray[np.float32]) -> NDArray[np.float32]:
    """Used probabilities where candidates were added at the end: theirs are the selector's own."""
    if len(used) == len(natural):
        return used
    longer = np.concatenate([used, natural[len(used) :]]).astype(np.float64)
    return np.asarray(longer / longer.sum(), np.float32)
