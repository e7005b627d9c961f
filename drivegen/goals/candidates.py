"""Candidate goals of a vehicle: where it may be at the end (paper, "Scenario Rollout": sampled goals on all routes).

All feasible routes are found, each gets places that can be reached within the horizon, weighted by a prior, and at most
`most` of them are kept so that they cover the prior's mass. A vehicle that stands may stay; one that is on no lane gets
goals on arcs ahead of it.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, rotate, wrap_angle
from drivegen.core.roadmap import NO_LANE
from drivegen.core.scenario import DT, Scenario
from drivegen.core.settings import Within
from drivegen.goals.cover import cover
from drivegen.goals.kerb import kerb_place
from drivegen.goals.manoeuvres import Manoeuvre, manoeuvres
from drivegen.goals.prior import Places, places, shares
from drivegen.goals.traffic import Ahead, Neighbours, look_ahead
from drivegen.roads.frenet import from_frenet, to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import SPACING, Route
from drivegen.roads.parked import STANDING
from drivegen.roads.reach import Dynamics, end_speed, stopping_distance
from drivegen.roads.routes import feasible_routes

NO_ROUTE = -1
"""The route of a candidate off the lanes."""

MAY_STAY = 2.0
"""A vehicle slower than this [m/s] may end where it is."""

SETTLE = 25.0
"""A vehicle's offset from its lane's middle fades with this length [m]."""

KERB = 0.02
"""Prior weight of pulling over."""

OFF_LANE = 3.5
"""A vehicle farther from its route's line than this [m] also gets goals off the lanes."""

CURVATURES = (-1 / 8, -1 / 20, 0.0, 1 / 20, 1 / 8)
"""Bends of the arcs that a vehicle off the lanes may drive [1/m]."""

MOST_ARC = 30.0
"""Arcs end after this distance [m]: nobody crosses a car park for longer."""

MOST_HALTS = 6
"""Places to stop at (red light, standing leader, junction) that are always offered, at most."""

FINER = (1.05, 0.5)
"""Shares of the spacing that candidates stand for; the second adds more of them while there is room."""


MOST = 40
"""Candidates of a vehicle, at most: lists are padded to so many, so that a result does not depend on its batch."""


@dataclass(frozen=True)
class Settings:
    """How candidates are made.

    Attributes:
        most: candidates per vehicle at most. most_routes: routes per vehicle at most.
        spacing: [m] between the places that are considered; a candidate stands for itself and the next one on either side.
        dynamics: bounds on acceleration.
    """

    most: Annotated[int, Within(1, MOST)]
    most_routes: Annotated[int, Within(1, 100)]
    spacing: Annotated[float, Within(0.1, 100)]
    dynamics: Dynamics


@dataclass(frozen=True)
class Candidates:
    """C candidate end states of one vehicle, at least one.

    Attributes:
        position: (C, 2) float32 [m]. heading: (C,) float32 [rad]. speed: (C,) float32 [m/s] at the end.
        route: (C,) int32 index into `routes`, NO_ROUTE off the lanes. s, d: (C,) float32 [m] along and left of it.
        step: (C,) int32 at which it is reached, the scenario's last one unless the log ends before.
        manoeuvre: (C,) uint8 Manoeuvre. lane: (C,) int32 lane at the end, NO_LANE off the lanes.
        leaves_map: (C,) bool the end lies beyond the map. prior: (C,) float32 mass that the candidate stands for, sum 1.
        routes: the routes. ahead: what is in the way on each of them at the first frame.
        offset: (R,) float32 [m] of the vehicle itself to the left of each route's line.
    """

    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    speed: NDArray[np.float32]
    route: NDArray[np.int32]
    s: NDArray[np.float32]
    d: NDArray[np.float32]
    step: NDArray[np.int32]
    manoeuvre: NDArray[np.uint8]
    lane: NDArray[np.int32]
    leaves_map: NDArray[np.bool_]
    prior: NDArray[np.float32]
    routes: tuple[Route, ...]
    ahead: tuple[Ahead, ...]
    offset: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.heading)

    def with_more(self, **columns: Any) -> "Candidates":
        """These and, at the end, K more, which `columns` (K, ...) describe, `position` to `prior`; priors are not shared anew."""
        longer: dict[str, Any] = {}
        for name, values in columns.items():
            before = getattr(self, name)
            longer[name] = np.concatenate([before, np.asarray(values, before.dtype)])
        return replace(self, **longer)


def candidates(graph: LaneGraph, scenario: Scenario, vehicle: int, settings: Settings) -> Candidates:
    """Candidates of `vehicle` at the end of the scenario's horizon, by what is seen at step 0.

    Deterministic; sorted by route, then by distance. Never empty: a vehicle that can go nowhere stays.
    """
    return candidates_on(routes_of(graph, scenario, vehicle, settings), scenario, vehicle, settings)


def routes_of(graph: LaneGraph, scenario: Scenario, vehicle: int, settings: Settings) -> list[Route]:
    """The routes on which `candidates` looks for places."""
    v, speed = scenario.vehicles, _speed(scenario, vehicle)
    reach = _reach(speed, settings.dynamics, scenario.horizon * DT)
    place, kind = (v.position[vehicle], float(v.heading[vehicle])), int(v.kind[vehicle])
    return feasible_routes(graph, *place, speed, reach, settings.most_routes, kind=kind)


def candidates_on(routes: list[Route], scenario: Scenario, vehicle: int, settings: Settings) -> Candidates:
    """As `candidates`, on routes that were found before."""
    seconds, v, speed = scenario.horizon * DT, scenario.vehicles, _speed(scenario, vehicle)
    position, heading = v.position[vehicle], float(v.heading[vehicle])
    reach = _reach(speed, settings.dynamics, seconds)
    around = Neighbours.of(scenario, vehicle).near(position, reach + 20.0)
    ahead = [look_ahead(scenario, route, around, float(v.size[vehicle, 0])) for route in routes]
    offset = np.array([to_frenet(route, position[None])[0, 1] for route in routes], np.float32)
    off_lane = not routes or np.abs(offset).min() > OFF_LANE
    arcs = [_arcs(position, heading, speed, settings.dynamics, seconds)] if off_lane else []
    can_go = routes or any(len(table.s) for table in arcs)
    tables = [_stay(position, heading, routes, offset, speed)] if speed < MAY_STAY or not can_go else []
    stays, weights = np.arange(len(tables)), shares(routes)
    for number, (route, what) in enumerate(zip(routes, ahead, strict=True)):
        where = places(route, speed, what, settings.dynamics, settings.spacing, seconds)
        where = replace(where, mass=where.mass * weights[number])
        tables.append(_on_route(number, route, where, float(offset[number]), speed, seconds))
    tables += arcs
    kerbs = _kerbs(scenario, vehicle, routes, offset, speed, seconds)
    stays = np.append(stays, sum(len(table.s) for table in tables) + np.arange(len(kerbs)))
    whole = _Table.joined([*tables, *kerbs])
    halts = np.flatnonzero(whole.halt)
    halts = halts[cover(whole.position[halts], whole.mass[halts], halts[:0], settings.spacing, MOST_HALTS)]
    keep = np.concatenate([stays, halts])  # staying, the kerb and the very places to stop at come before all others
    for share in FINER:
        keep = cover(whole.position, whole.mass, keep, share * settings.spacing, settings.most)
    keep = keep[np.lexsort((whole.s[keep], whole.route[keep]))]
    return whole.finished(keep, routes, ahead, offset, scenario.horizon)


def _speed(scenario: Scenario, vehicle: int) -> float:
    return float(max(scenario.vehicles.speed[vehicle], 0.0))


def _reach(speed: float, dynamics: Dynamics, seconds: float) -> float:
    """Length of routes [m]: for who gathers speed up to 1.2 times its own, 18 m/s at least, and 3 m/s more.

    Some vehicles get farther: 4 to 9 of 1 000 in the corpus have no candidate within 8 m of their end (`LOG.md`).
    """
    fastest = max(speed * 1.2, 18.0) + 3.0
    time = min((fastest - speed) / dynamics.acceleration, seconds)
    return speed * time + dynamics.acceleration * time**2 / 2 + fastest * (seconds - time) + 10.0


@dataclass(frozen=True)
class _Table:
    """Q places of all kinds with their prior mass; the columns of `Candidates`."""

    position: Floats
    heading: Floats
    speed: Floats
    route: NDArray[np.int32]
    s: Floats
    d: Floats
    manoeuvre: NDArray[np.uint8]
    lane: NDArray[np.int32]
    leaves_map: NDArray[np.bool_]
    mass: Floats
    halt: NDArray[np.bool_]

    @classmethod
    def joined(cls, tables: "list[_Table]") -> "_Table":
        return cls(*(np.concatenate([getattr(t, name) for t in tables]) for name in cls.__dataclass_fields__))

    def finished(
        self, keep: NDArray[np.intp], routes: list[Route], ahead: list[Ahead], offset: NDArray[np.float32], step: int
    ) -> Candidates:
        """The chosen rows; each inherits the mass of the places nearest to it."""
        prior = np.bincount(_nearest(self.position, self.position[keep]), self.mass, len(keep))
        return Candidates(
            position=self.position[keep].astype(np.float32),
            heading=wrap_angle(self.heading[keep]).astype(np.float32),
            speed=self.speed[keep].astype(np.float32),
            route=self.route[keep],
            s=self.s[keep].astype(np.float32),
            d=self.d[keep].astype(np.float32),
            step=np.full(len(keep), step, np.int32),
            manoeuvre=self.manoeuvre[keep],
            lane=self.lane[keep],
            leaves_map=self.leaves_map[keep],
            prior=(prior / prior.sum()).astype(np.float32),
            routes=tuple(routes),
            ahead=tuple(ahead),
            offset=offset,
        )


@njit(cache=True)
def _nearest(places, chosen):  # type: ignore[no-untyped-def]
    """(Q,) which of the chosen ones (K, 2) is nearest to each of the places (Q, 2)."""
    nearest = np.zeros(len(places), np.int64)
    for q in range(len(places)):
        best = np.inf
        for k in range(len(chosen)):
            dx, dy = places[q, 0] - chosen[k, 0], places[q, 1] - chosen[k, 1]
            if dx * dx + dy * dy < best:
                best, nearest[q] = dx * dx + dy * dy, k
    return nearest


def _on_route(number: int, route: Route, where: Places, offset: float, speed: float, seconds: float) -> _Table:
    """Places along a route; the vehicle's own offset fades on the way."""
    d = offset * np.exp(-where.s / SETTLE)
    position, heading = from_frenet(route, where.s, d)
    final = np.where(where.stop, 0.0, end_speed(where.s, speed, where.cap, seconds))
    at = np.minimum((where.s / SPACING).astype(int), len(route.lane) - 1)
    return _Table(
        position=position,
        heading=heading,
        speed=final,
        route=np.full(len(at), number, np.int32),
        s=where.s,
        d=d,
        manoeuvre=manoeuvres(route, where.s, final),
        lane=route.lane[at],
        leaves_map=where.s > route.exit_s,
        mass=where.mass,
        halt=where.stop,
    )


def _stay(position: Floats, heading: float, routes: list[Route], offset: NDArray[np.float32], speed: float) -> _Table:
    """The place where the vehicle is."""
    number = int(np.argmin(np.abs(offset))) if routes else NO_ROUTE
    return _Table(
        position=position[None],
        heading=np.array([heading]),
        speed=np.zeros(1),
        route=np.array([number], np.int32),
        s=np.zeros(1),
        d=offset[number : number + 1] if routes else np.zeros(1),
        manoeuvre=np.array([Manoeuvre.STAY], np.uint8),
        lane=np.array([routes[number].lane[0] if routes else NO_LANE], np.int32),
        leaves_map=np.zeros(1, np.bool_),
        mass=np.array([1.0 if speed < STANDING else 0.3]),
        halt=np.zeros(1, np.bool_),
    )


def _kerbs(
    scenario: Scenario, vehicle: int, routes: list[Route], offset: NDArray[np.float32], speed: float, seconds: float
) -> list[_Table]:
    """The place at the kerb of the route that the vehicle is most nearly on, if there is one."""
    number = int(np.argmin(np.abs(offset))) if routes else NO_ROUTE
    place = (
        kerb_place(routes[number], scenario.map, speed, float(scenario.vehicles.size[vehicle, 1]), seconds) if routes else None
    )
    if place is None:
        return []
    s, d = (np.array([value]) for value in place)
    position, heading = from_frenet(routes[number], s, d)
    one = _stay(position[0], float(heading[0]), routes, offset, speed)
    parked, mass = np.array([Manoeuvre.PARK], np.uint8), np.array([KERB])
    return [replace(one, s=s, d=d, manoeuvre=parked, lane=routes[number].lane[(s / SPACING).astype(int)], mass=mass)]


def _arcs(position: Floats, heading: float, speed: float, dynamics: Dynamics, seconds: float) -> _Table:
    """Places on arcs ahead of a vehicle that is on no lane; sharper arcs end sooner."""
    nearest = stopping_distance(speed, dynamics.braking, seconds)
    steady = min(speed, 8.0) * seconds
    s = np.arange(max(nearest, 4.0), max(MOST_ARC, min(steady, 3 * MOST_ARC)), 4.0)
    bend, along = (a.ravel() for a in np.meshgrid(CURVATURES, s, indexing="ij"))
    keep = np.abs(bend * along) <= np.pi / 2 + 0.1
    bend, along = bend[keep], along[keep]
    angle = bend * along
    local = along[:, None] * np.stack([np.sinc(angle / np.pi), np.sin(angle / 2) * np.sinc(angle / 2 / np.pi)], axis=-1)
    count = len(along)
    none = np.zeros(count, np.float64)
    return _Table(
        position=position + rotate(local, np.full(count, heading)),
        heading=heading + angle,
        speed=end_speed(along, speed, np.full(count, 15.0), seconds),
        route=np.full(count, NO_ROUTE, np.int32),
        s=none,
        d=none,
        manoeuvre=np.full(count, Manoeuvre.OFF_LANE, np.uint8),
        lane=np.full(count, NO_LANE, np.int32),
        leaves_map=np.zeros(count, np.bool_),
        mass=np.where(bend == 0, 2.0, 1.0) / count,
        halt=np.zeros(count, np.bool_),
    )
