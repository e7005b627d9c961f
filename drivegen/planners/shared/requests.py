"""Plan requests: what a planner must know of a vehicle, its goal and its route, as arrays over many scenarios.

`plan_requests` makes them for chosen goals (generation), `examples_from_logs` for the goal that a logged track reached
(training): both fill in the same context, so a planner is asked in the way it was taught.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.geometry import Floats
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.planners.base import ROUTE_POINTS, ROUTE_SPACING, Examples, PlanRequests
from drivegen.roads.frenet import to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import Route
from drivegen.roads.routes import match_route

FACING = np.pi / 3
"""A vehicle counts as a leader if its heading differs from the route's by less than this [rad]."""

ABREAST = 3.0
"""A route begins within this distance [m] along it from its vehicle."""

LATERAL_MARGIN = 0.3
"""Boxes that pass each other nearer than this are in each other's way [m]."""


@dataclass(frozen=True)
class Goals:
    """B chosen goals, one per wanted trajectory; `route` counts through a list of routes, -1 where none fits.

    Attributes:
        scenario, vehicle: (B,) int. position: (B, 2) [m]. heading: (B,) [rad]. speed: (B,) [m/s].
        step: (B,) int, the step at which the goal is reached.
        route: (B,) int. s, d: (B,) [m] the goal along and left of its route.
    """

    scenario: NDArray[np.integer]
    vehicle: NDArray[np.integer]
    position: Floats
    heading: Floats
    speed: Floats
    step: NDArray[np.integer]
    route: NDArray[np.integer]
    s: Floats
    d: Floats


def plan_requests(scenarios: Sequence[Scenario], routes: Sequence[Route], goals: Goals, seed: NDArray[np.int64]) -> PlanRequests:
    """Requests (B,) for `goals`, drawing noise from `seed` (B,).

    Every route belongs to one vehicle: its s = 0 is abreast of it. A route that several goals share is looked at once;
    one that begins elsewhere counts as none.
    """
    of_vehicle = [scenario.vehicles for scenario in scenarios]
    start = np.cumsum([0, *(len(v) for v in of_vehicle)])
    row = start[goals.scenario] + goals.vehicle
    position = np.concatenate([v.position for v in of_vehicle])[row]
    goals = replace(goals, route=_abreast(position, routes, goals))
    leader_gap, leader_speed, stop_s = _traffic_ahead(scenarios, routes, goals)
    line, length, limit = _route_table(routes)

    def state(name: str) -> NDArray[np.float32]:
        return np.asarray(np.concatenate([getattr(v, name) for v in of_vehicle])[row], np.float32)

    return PlanRequests(
        scenario=goals.scenario.astype(np.int32),
        vehicle=goals.vehicle.astype(np.int32),
        position=state("position"),
        heading=state("heading"),
        speed=state("speed"),
        size=state("size"),
        goal_position=goals.position.astype(np.float32),
        goal_heading=goals.heading.astype(np.float32),
        goal_speed=goals.speed.astype(np.float32),
        goal_step=goals.step.astype(np.int32),
        route=goals.route.astype(np.int32),
        route_line=line,
        route_length=length,
        route_speed_limit=limit,
        goal_s=goals.s.astype(np.float32),
        goal_d=goals.d.astype(np.float32),
        leader_gap=leader_gap,
        leader_speed=leader_speed,
        stop_s=stop_s,
        seed=np.asarray(seed, np.int64),
    )


def moved(
    requests: PlanRequests, along: NDArray[np.floating], across: NDArray[np.floating], speed: NDArray[np.floating]
) -> PlanRequests:
    """Requests whose goals lie `along` (B,) [m] farther on their routes and `across` [m] more to the left, `speed` [m/s] faster.

    They stay on the route, never behind their vehicle, and no slower than standing. A goal that is not moved, without a route,
    or beyond the table of its route, stays what it is.
    """
    elsewhere = (along != 0) | (across != 0) | (speed != 0)
    on = elsewhere & (requests.route >= 0) & (requests.goal_s <= ROUTE_SPACING * (ROUTE_POINTS - 1))
    if not on.any():
        return requests
    last = np.minimum(requests.route_length[requests.route], ROUTE_SPACING * (ROUTE_POINTS - 1))
    s = np.clip(requests.goal_s + along, 0.0, last)
    d = requests.goal_d + across
    first = np.minimum((s / ROUTE_SPACING).astype(np.int64), ROUTE_POINTS - 2)
    begin, end = (requests.route_line[requests.route, point].astype(np.float64) for point in (first, first + 1))
    step = (end - begin) / ROUTE_SPACING
    left = np.stack([-step[:, 1], step[:, 0]], axis=-1)
    place = begin + step * (s - first * ROUTE_SPACING)[:, None] + left * d[:, None]

    def where_on(value: NDArray[np.floating], before: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.where(on.reshape(-1, *[1] * (before.ndim - 1)), value, before).astype(np.float32)

    return replace(
        requests,
        goal_position=where_on(place, requests.goal_position),
        goal_heading=where_on(np.arctan2(step[:, 1], step[:, 0]), requests.goal_heading),
        goal_speed=where_on(np.maximum(requests.goal_speed + speed, 0.0), requests.goal_speed),
        goal_s=where_on(s, requests.goal_s),
        goal_d=where_on(d, requests.goal_d),
    )


def examples_from_logs(scenarios: Sequence[Scenario], graphs: Sequence[LaneGraph], min_seen: float, seed: int) -> Examples:
    """All logged tracks that are there at step 0 and at `min_seen` (0..1) of the steps, two at least, with their own end as goal.

    The route is the one that the track followed (`match_route`), none where none fits; the goal is the last valid step.
    """
    matches: list[tuple[int, int, Route | None]] = []
    for s, (scenario, graph) in enumerate(zip(scenarios, graphs, strict=True)):
        if scenario.log is None:
            continue
        valid = scenario.log.valid
        for vehicle in np.flatnonzero(valid[:, 0] & (valid.sum(-1) >= max(2, min_seen * scenario.steps))):
            present, track, kind = valid[vehicle], scenario.log[vehicle], int(scenario.vehicles.kind[vehicle])
            route = match_route(graph, track.position[present], track.heading[present], kind=kind)
            matches.append((s, int(vehicle), route))
    return _examples(scenarios, matches, seed)


def _examples(scenarios: Sequence[Scenario], matches: list[tuple[int, int, Route | None]], seed: int) -> Examples:
    steps = max((s.steps for s in scenarios), default=1)
    motion = Trajectories.empty(len(matches), steps)
    routes: list[Route] = []
    route, along = np.full(len(matches), -1), np.zeros((len(matches), 2))
    for i, (s, vehicle, matched) in enumerate(matches):
        log = scenarios[s].log
        assert log is not None
        motion.put(i, log[vehicle].padded(steps))
        if matched is not None:
            end = log.position[vehicle, log[vehicle].last_valid()]
            route[i], along[i] = len(routes), to_frenet(matched, end[None])[0]
            routes.append(matched)
    last, row = motion.last_valid(), np.arange(len(matches))
    goals = Goals(
        scenario=np.array([f[0] for f in matches], np.int32),
        vehicle=np.array([f[1] for f in matches], np.int32),
        position=motion.position[row, last],
        heading=motion.heading[row, last],
        speed=motion.speed[row, last],
        step=last,
        route=route,
        s=along[:, 0],
        d=along[:, 1],
    )
    words = [(scenarios[s].scenario_id, vehicle) for s, vehicle, _ in matches]
    own_seed = np.array([seeds.derive(seed, "example", *w) for w in words], np.int64)
    return Examples(scenarios, plan_requests(scenarios, routes, goals, own_seed), motion)


def _abreast(position: Floats, routes: Sequence[Route], goals: Goals) -> NDArray[np.integer]:
    """Goals' routes (B,), -1 for those that do not begin within ABREAST of their vehicle at `position` (B, 2) (maps end,
    matches fail).
    """
    on_route = np.flatnonzero(goals.route >= 0)
    if not len(on_route):
        return goals.route
    first, second = (np.array([route.line[point] for route in routes])[goals.route[on_route]] for point in (0, 1))
    along = ((position[on_route] - first) * (second - first)).sum(1)
    route_of = goals.route.copy()
    route_of[on_route[np.abs(along) > ABREAST * ROUTE_SPACING]] = -1
    return route_of


def _route_table(routes: Sequence[Route]) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Lines (R, P, 2), lengths (R,), speed limits (R, P), padded to ROUTE_POINTS: straight on, with the last limit."""
    line = np.zeros((len(routes), ROUTE_POINTS, 2), np.float32)
    limit = np.full((len(routes), ROUTE_POINTS), np.nan, np.float32)
    length = np.zeros(len(routes), np.float32)
    for r, route in enumerate(routes):
        count = min(len(route.line), ROUTE_POINTS)
        line[r, :count], limit[r, :count] = route.line[:count], route.speed_limit[:count]
        length[r] = (count - 1) * ROUTE_SPACING
        ahead = route.line[count - 1] - route.line[count - 2] if count > 1 else np.zeros(2)
        ahead = ahead / max(float(np.hypot(*ahead)), 1e-6) * ROUTE_SPACING
        line[r, count:] = route.line[count - 1] + np.arange(1, ROUTE_POINTS - count + 1)[:, None] * ahead
        limit[r, count:] = limit[r, count - 1]
    return line, length, limit


def _traffic_ahead(
    scenarios: Sequence[Scenario], routes: Sequence[Route], goals: Goals
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Leader gap, leader speed and stop distance (B,) of every goal."""
    gap, speed, stop = (np.full(len(goals.route), value, np.float32) for value in (np.inf, 0.0, np.inf))
    on_route = np.flatnonzero(goals.route >= 0)
    _, first, inverse = np.unique(goals.route[on_route], return_index=True, return_inverse=True)
    ahead = np.zeros((len(first), 3), np.float32)
    boxes = {s: _boxes(scenarios[s]) for s in np.unique(goals.scenario[on_route]).tolist()}
    for u, b in enumerate(on_route[first].tolist()):
        s, route = int(goals.scenario[b]), routes[goals.route[b]]
        ahead[u, :2] = _leader(*boxes[s], int(goals.vehicle[b]), route.line[:ROUTE_POINTS])
        ahead[u, 2] = _next_stop(scenarios[s], route)
    gap[on_route], speed[on_route], stop[on_route] = ahead[inverse].T
    return gap, speed, stop


def _boxes(scenario: Scenario) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """States (M, 4) x, y, heading, speed and sizes (M, 2) at step 0: vehicles, then context actors that are there."""
    everybody = scenario.present()
    states = np.column_stack([everybody.position, everybody.heading, everybody.speed])
    return states.astype(np.float32), everybody.size[:, :2]


@njit(cache=True)
def _leader(state: NDArray[np.float32], size: NDArray[np.float32], me: int, line: NDArray[np.float32]) -> tuple[float, float]:
    """Gap [m] and speed [m/s] along the route of the nearest box ahead on it; (inf, 0) if there is none."""
    best, speed = np.inf, 0.0
    for other in range(len(state)):
        if other == me or len(line) < 2:
            continue
        nearest, squared = 0, np.inf
        for p in range(len(line)):
            dx, dy = state[other, 0] - line[p, 0], state[other, 1] - line[p, 1]
            if dx * dx + dy * dy < squared:
                nearest, squared = p, dx * dx + dy * dy
        at = min(nearest, len(line) - 2)
        tx, ty = line[at + 1, 0] - line[at, 0], line[at + 1, 1] - line[at, 1]
        dx, dy = state[other, 0] - line[nearest, 0], state[other, 1] - line[nearest, 1]
        along = nearest * ROUTE_SPACING + dx * tx + dy * ty
        turn = (state[other, 2] - np.arctan2(ty, tx) + np.pi) % (2 * np.pi) - np.pi
        wide = (size[me, 1] + size[other, 1]) / 2 + LATERAL_MARGIN
        gap = along - (size[me, 0] + size[other, 0]) / 2
        if along > 0 and abs(tx * dy - ty * dx) < wide and abs(turn) < FACING and gap < best:
            best, speed = gap, max(0.0, state[other, 3] * np.cos(turn))
    return max(best, 0.0), speed


def _next_stop(scenario: Scenario, route: Route) -> float:
    """Distance [m] along the route to the first lane entered under red or yellow at step 0; inf if there is none."""
    signals = scenario.signals
    closed = signals.lane[signals.closed[:, 0]]
    if not len(closed):
        return np.inf
    hit = route.entries[np.isin(route.lane[route.entries], closed)]
    return float(hit[0] * ROUTE_SPACING) if len(hit) else np.inf
