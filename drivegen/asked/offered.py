"""Goals that a manoeuvre needs and that nobody would usually have: they are added to a vehicle's candidates at the end.

The selector gives odds to them as to all others, so their price in realism is seen.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import to_vehicle_frame
from drivegen.core.scenario import DT, TARGET, Scenario
from drivegen.goals.candidates import SETTLE, Candidates
from drivegen.goals.manoeuvres import manoeuvres
from drivegen.roads.frenet import from_frenet, to_frenet
from drivegen.roads.line import SPACING, Route
from drivegen.roads.reach import end_speed
from drivegen.words.request import Manoeuvre

HARD, HARDEST = 3.0, 4.5
"""Who stops within its speed's square over twice the first [m/s2] has to brake hard; nobody is asked for more than the second."""

PACES = (0.7, 0.85, 1.0, 1.15)
"""Who changes lanes may go on at these shares of its speed, so that a gap beside it can be met."""


def side_of(scenario: Scenario, vehicle: int, manoeuvre: Manoeuvre, way: Route | None) -> int | None:
    """To which side the vehicle changes lanes for its manoeuvre: 1 left, -1 right; None where it stays in its lane.

    It cuts in from beside the target's `way`, where that has one: in a bend this may be the other side than it is seen on.
    """
    if manoeuvre is Manoeuvre.CUT_IN:
        seen = scenario.vehicles
        place = seen.position[vehicle][None]
        d = to_frenet(way, place) if way else to_vehicle_frame(place, seen.position[TARGET], seen.heading[TARGET])
        return -1 if d[0, 1] > 0 else 1
    return {Manoeuvre.CHANGE_LEFT: 1, Manoeuvre.CHANGE_RIGHT: -1}.get(manoeuvre)


def offered(scenario: Scenario, vehicle: int, manoeuvre: Manoeuvre, given: Candidates, way: Route | None) -> Candidates:
    """The candidates of `vehicle`, with more that serve its manoeuvre where that has any of its own; `way`: the target's."""
    if manoeuvre is Manoeuvre.HARD_BRAKING:
        return _with_stop(scenario, vehicle, given)
    side = side_of(scenario, vehicle, manoeuvre, way)
    return given if side is None else _with_changes(scenario, vehicle, given, side)


def _with_stop(scenario: Scenario, vehicle: int, given: Candidates) -> Candidates:
    """A halt on the vehicle's own route after braking as hard as anybody is asked to."""
    number = next((i for i, route in enumerate(given.routes) if route.lane_changes == 0), None)
    speed = float(scenario.vehicles.speed[vehicle])
    if number is None or speed < 1.0:
        return given
    s = min(speed**2 / (HARD + HARDEST), given.routes[number].length)
    return _with(scenario, given, number, np.array([s]), np.zeros(1))


def _with_changes(scenario: Scenario, vehicle: int, given: Candidates, side: int) -> Candidates:
    """Places in the next lane on that `side` (1 left, -1 right), for going on more slowly and faster than now."""
    speed, seconds = float(scenario.vehicles.speed[vehicle]), scenario.horizon * DT
    for number, route in enumerate(given.routes):
        s = np.array(PACES) * speed * seconds
        s = s[s < min(route.length, route.exit_s) - SPACING]
        s = s[route.shift[(s / SPACING).astype(int)] == side]
        if route.lane_changes == 1 and len(s):
            caps = np.full(len(s), 1.2 * speed)
            return _with(scenario, given, number, s, end_speed(s, speed, caps, seconds))
    return given


def _with(scenario: Scenario, given: Candidates, number: int, s: NDArray[Any], speed: NDArray[Any]) -> Candidates:
    """The candidates and those on route `number` at `s` (K,) [m], reached with `speed` (K,) [m/s]."""
    route = given.routes[number]
    d = float(given.offset[number]) * np.exp(-s / SETTLE)
    position, heading = from_frenet(route, s, d)
    return given.with_more(
        position=position,
        heading=heading,
        speed=speed,
        route=np.full(len(s), number),
        s=s,
        d=d,
        step=np.full(len(s), scenario.horizon),
        manoeuvre=manoeuvres(route, s, speed),
        lane=route.lane[np.minimum((s / SPACING).astype(int), len(route.lane) - 1)],
        leaves_map=s > route.exit_s,
        prior=np.zeros(len(s)),
    )
