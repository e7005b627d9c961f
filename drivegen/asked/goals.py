"""Manoeuvres as goals: of a vehicle's candidates only those that realise what it is to do keep their probability.

What the selector itself gives to those goals is kept beside it (`Choices.natural`): the price in realism of the words.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.asked.request import Manoeuvre
from drivegen.asked.wishes import TARGET
from drivegen.geometry import to_vehicle_frame
from drivegen.goals.candidates import Candidates, manoeuvres
from drivegen.goals.candidates import Manoeuvre as Way
from drivegen.lanes.frenet import from_frenet, to_frenet
from drivegen.lanes.graph import LaneGraph
from drivegen.lanes.line import SPACING, Route
from drivegen.rollout import Choices
from drivegen.scenario import DT, Scenario
from drivegen.selectors.base import Selector

HARD = 3.0
"""Who stops within its speed's square over twice this [m/s2] has to brake hard."""

HARDEST = 4.5
"""Nobody is asked to brake harder than this [m/s2] on average."""

IN_LANE = 1.6
"""Who is within this of a route's line [m] is in its lane."""

PAST = 8.0
"""Who has overtaken is so far ahead [m], centre to centre."""

_DIRECT = {
    Manoeuvre.TURN_LEFT: Way.LEFT,
    Manoeuvre.TURN_RIGHT: Way.RIGHT,
    Manoeuvre.TURN_LEFT_ACROSS: Way.LEFT,
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
        choices: `used` is zero for goals that do not realise a vehicle's duty. feasible: of each duty, whether any goal does.
        natural: of each duty, the probability that the selector itself gives to the goals that do.
    """

    choices: Choices
    feasible: tuple[bool, ...]
    natural: tuple[float, ...]


def ordered(graph: LaneGraph, choices: Choices, selector: Selector, duties: Sequence[Duty]) -> Ordered:
    """The choices with each duty's vehicle bound to goals that realise it; a duty that no goal realises changes nothing."""
    offered = list(choices.candidates)
    for duty in duties:
        if duty.manoeuvre is Manoeuvre.HARD_BRAKING:
            offered[duty.vehicle] = _with_stop(choices.scenario, duty.vehicle, offered[duty.vehicle])
    natural, used = list(choices.natural), list(choices.used)
    if any(len(a) != len(b) for a, b in zip(offered, choices.candidates, strict=True)):
        natural = selector.rank(graph, choices.scenario, offered)
        used = [_fitted(u, n) for u, n in zip(used, natural, strict=True)]
    feasible, mass = [], []
    for duty in duties:
        realises = realising(choices.scenario, offered, duty)
        feasible.append(bool(realises.any()))
        mass.append(float(natural[duty.vehicle][realises].sum()))
        used[duty.vehicle] = _bound(used[duty.vehicle], realises)
        if duty.vehicle != TARGET and not any(other.vehicle == TARGET for other in duties):
            used[TARGET] = _bound(used[TARGET], _target_lets(offered[TARGET], choices.scenario, duty))
    return Ordered(Choices(choices.scenario, offered, natural, used), tuple(feasible), tuple(mass))


def realising(scenario: Scenario, candidates: Sequence[Candidates], duty: Duty) -> NDArray[np.bool_]:
    """(C,) which candidates of the duty's vehicle realise it."""
    own = candidates[duty.vehicle]
    if duty.manoeuvre in _DIRECT:
        return np.asarray(own.manoeuvre == _DIRECT[duty.manoeuvre])
    speed = float(scenario.vehicles.speed[duty.vehicle])
    if duty.manoeuvre is Manoeuvre.HARD_BRAKING:
        near = own.s <= speed**2 / (2 * HARD) + SPACING
        return np.asarray(near & (own.speed < 1.0) & np.isin(own.manoeuvre, (Way.KEEP, Way.STOP)))
    ahead = keeping(candidates[TARGET])
    if ahead is None:
        return np.zeros(len(own), np.bool_)
    s, d = to_frenet(ahead, own.position).T
    if duty.manoeuvre is Manoeuvre.CUT_IN:
        y = to_vehicle_frame(scenario.vehicles.position[duty.vehicle][None], *_pose(scenario))[0, 1]
        way = Way.CHANGE_RIGHT if y > 0 else Way.CHANGE_LEFT
        return np.asarray((own.manoeuvre == way) & (np.abs(d) < IN_LANE))
    expected = float(scenario.vehicles.speed[TARGET]) * scenario.horizon * DT
    return np.asarray((s > expected + PAST) & (own.manoeuvre != Way.STAY))  # OVERTAKE


def keeping(candidates: Candidates) -> Route | None:
    """The vehicle's first route without a lane change."""
    return next((route for route in candidates.routes if route.lane_changes == 0), None)


def _pose(scenario: Scenario) -> tuple[Any, Any]:
    return scenario.vehicles.position[TARGET], scenario.vehicles.heading[TARGET]


def _target_lets(own: Candidates, scenario: Scenario, duty: Duty) -> NDArray[np.bool_]:
    """(C,) goals of the target with which the other vehicle's manoeuvre means something: it drives on in its lane."""
    on = np.isin(own.manoeuvre, (Way.KEEP, Way.STOP))
    if duty.manoeuvre is Manoeuvre.OVERTAKE:
        pace = float(scenario.vehicles.speed[TARGET])
        return np.asarray(on & (own.s <= 1.05 * pace * scenario.horizon * DT))
    return on


def _bound(used: NDArray[np.float32], allowed: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Probabilities of the allowed alone; unchanged where none is allowed, equal where the allowed had none."""
    if not allowed.any():
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


def _with_stop(scenario: Scenario, vehicle: int, given: Candidates) -> Candidates:
    """The candidates with one more at the end: a halt on the vehicle's own route after braking as hard as anybody is asked to."""
    number = next((i for i, route in enumerate(given.routes) if route.lane_changes == 0), None)
    speed = float(scenario.vehicles.speed[vehicle])
    if number is None or speed < 1.0:
        return given
    route = given.routes[number]
    s = min(speed**2 / (HARD + HARDEST), route.length)
    d = float(given.offset[number])
    position, heading = from_frenet(route, np.array([s]), np.array([d]))
    row = {
        "position": position[0],
        "heading": heading[0],
        "speed": 0.0,
        "route": number,
        "s": s,
        "d": d,
        "step": scenario.horizon,
        "manoeuvre": manoeuvres(route, s, 0.0),
        "lane": route.lane[min(int(s / SPACING), len(route.lane) - 1)],
        "leaves_map": s > route.exit_s,
        "prior": 0.0,
    }
    columns: dict[str, Any] = {name: _appended(getattr(given, name), value) for name, value in row.items()}
    return replace(given, **columns)


def _appended(column: NDArray[np.generic], value: object) -> NDArray[np.generic]:
    return np.concatenate([column, np.asarray(value, column.dtype)[None]])
