"""What was asked for against what was got, by looking at the vehicles alone: where they stand and how they move.

Nothing here knows how a request was placed or which goals were drawn; routes serve as lines to measure along.
"""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.asked.goals import Duty, end_of_crossing
from drivegen.core.geometry import to_vehicle_frame, wrap_angle
from drivegen.core.roadmap import NO_LANE, RoadMap
from drivegen.core.scenario import DT, TARGET, Trajectories, Vehicles
from drivegen.goals.manoeuvres import U_TURN
from drivegen.placement.ways import crossed
from drivegen.placement.where import ALIKE, BESIDE, FARTHEST, NEAREST, TOLERANCE, TOLERANCE_SHARE, Relation
from drivegen.roads.frenet import from_frenet, to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import SPACING, Route
from drivegen.words.request import AT_JUNCTIONS, Manoeuvre

BRAKING = 3.0
"""A vehicle brakes hard when it slows down by more than this [m/s2] over BRAKING_STEPS steps."""

BRAKING_STEPS = 5

STANDING = 0.5
"""Slower than this [m/s] a vehicle stands."""

TURNED = np.deg2rad(45)
"""Whoever has turned heads so far [rad] behind a junction from where it headed before."""

AROUND = 10
"""Steps before and after a junction that belong to the turn: a narrow one begins before its junction does."""

INTO = 1.2
"""Who has changed into a lane is this near to its middle [m]; who is out of it at least OUT."""

OUT = 1.9

CLEAR = 2.0
"""Who has overtaken is more than this ahead [m], centre to centre."""

CHANGED, FARTHER = 2.5, 7.0
"""Who has changed lanes is between these [m] beside its own lane's middle; who is farther away is on another road."""

HALF_LANE = (1.4, 2.5)
"""Half of a lane's width [m] is taken for no less and no more; who is between one and three of them aside is in the next lane."""

ALONG = np.deg2rad(30)
"""Who is in a lane heads along it, within this [rad]; who crosses it or turns off does not."""

LASTING = 5
"""Steps running for which somebody is in a lane that it has changed or cut into."""

SLACK = 1.0
"""[m] and [s] by which a place or a time may be missed."""


def stands(
    routes: Sequence[Sequence[Route]], vehicles: Vehicles, vehicle: int, relation: Relation, distance: float | None
) -> bool:
    """Whether a vehicle stands in `relation` to the target; its routes tell what is ahead or beside on its road."""
    pose = vehicles.position[TARGET], vehicles.heading[TARGET]
    x, y = to_vehicle_frame(vehicles.position[vehicle][None], *pose)[0]
    turn = float(wrap_angle(vehicles.heading[vehicle] - vehicles.heading[TARGET]))
    if relation is Relation.ONCOMING:
        return abs(turn) > np.pi - ALIKE - 0.1 and x > 0 and _near(x, NEAREST - SLACK, FARTHEST + SLACK, distance)
    if relation in (Relation.FROM_LEFT, Relation.FROM_RIGHT):
        side = 1.0 if relation is Relation.FROM_LEFT else -1.0
        across = side * turn < 0 and abs(abs(turn) - np.pi / 2) < ALIKE + 0.1
        beside = _near(side * y, NEAREST - SLACK, FARTHEST + SLACK, None)
        return across and beside and x > 0 and _near(x, 0.0, FARTHEST + SLACK, distance)
    if relation in (Relation.AHEAD, Relation.BEHIND):
        follower, leader = (TARGET, vehicle) if relation is Relation.AHEAD else (vehicle, TARGET)
        places = [to_frenet(route, vehicles.position[leader][None])[0] for route in routes[follower]]
        return any(abs(d) < OUT and _near(s, NEAREST - SLACK, FARTHEST + SLACK, distance) for s, d in places)
    lengths = _beside(routes, vehicles, vehicle, 1.0 if relation.value.startswith("left") else -1.0)
    if relation.value.endswith("ahead"):
        return any(_near(s, NEAREST - SLACK, FARTHEST / 2 + SLACK, distance) for s in lengths)
    if relation.value.endswith("behind"):
        return any(_near(-s, NEAREST - SLACK, FARTHEST / 2 + SLACK, distance) for s in lengths)
    return any(_near(abs(s), 0.0, BESIDE + SLACK, distance) for s in lengths)


def _beside(routes: Sequence[Sequence[Route]], vehicles: Vehicles, vehicle: int, side: float) -> Iterator[float]:
    """How far ahead [m] a vehicle in the lane to a `side` of the target's is, below 0 behind: on each way of who follows."""
    for follower, leader, sign in ((TARGET, vehicle, 1.0), (vehicle, TARGET, -1.0)):
        for route in routes[follower]:
            s, d = to_frenet(route, vehicles.position[leader][None])[0].tolist()
            heading = from_frenet(route, np.array([s]), np.zeros(1))[1][0]
            alike = abs(wrap_angle(vehicles.heading[leader] - heading)) < ALIKE + 0.1
            half = np.clip(route.half_width_right[int(np.clip(s / SPACING, 0, len(route.line) - 1))], *HALF_LANE)
            if s > -SLACK and alike and half < sign * side * d < 3 * half:
                yield sign * s


def _near(along: float, low: float, high: float, distance: float | None) -> bool:
    if distance is None:
        return low <= along <= high
    return abs(along - distance) <= max(TOLERANCE, TOLERANCE_SHARE * distance) + SLACK


def queued(routes: Sequence[Sequence[Route]], vehicles: Vehicles, members: list[int]) -> bool:
    """Whether the vehicles `members` stand one behind another, the head first or last, close and on one way."""
    return len(members) > 1 and (_in_line(routes, vehicles, members) or _in_line(routes, vehicles, members[::-1]))


def _in_line(routes: Sequence[Sequence[Route]], vehicles: Vehicles, members: list[int]) -> bool:
    for leader, follower in itertools.pairwise(members):
        places = [to_frenet(route, vehicles.position[leader][None])[0] for route in routes[follower]]
        length = float(vehicles.size[leader, 0] + vehicles.size[follower, 0]) / 2
        farthest = 10.0 + 2.5 * float(vehicles.speed[follower])
        if not any(abs(d) < OUT and 0 < s - length < farthest for s, d in places):
            return False
    return True


def does(
    duty: Duty, motion: Trajectories, target_routes: Sequence[Route], own_routes: Sequence[Route], road_map: RoadMap
) -> bool:
    """Whether the vehicle does its duty in the motion (N, T) of one sample, in time.

    `target_routes`, the one that the target follows first, and `own_routes` keep their lanes: what "in its lane" means for the
    target and for the vehicle. Routes lie on `road_map`. Who leaves the map is looked at until then.
    """
    track, target = (_there(motion[n]) for n in (duty.vehicle, TARGET))
    if not track.steps or not target.steps:
        return False
    last = track.steps if duty.within is None else min(track.steps, round((duty.within + SLACK) / DT) + 1)
    if duty.manoeuvre is Manoeuvre.STOPPED:
        return bool((track.speed < STANDING).all())
    if duty.manoeuvre is Manoeuvre.HARD_BRAKING:
        return bool(hardest_braking(track)[:last].max(initial=0.0) >= BRAKING)
    if duty.manoeuvre in AT_JUNCTIONS:
        return _at_junction(duty.manoeuvre, track, target_routes, own_routes, road_map, last)
    if duty.manoeuvre in (Manoeuvre.CHANGE_LEFT, Manoeuvre.CHANGE_RIGHT):
        side = 1.0 if duty.manoeuvre is Manoeuvre.CHANGE_LEFT else -1.0
        return bool(own_routes) and _lasts(_changed(own_routes, track, side)[:last])
    return bool(target_routes) and _before_target(duty, track, target, target_routes[0], last)


def _there(track: Trajectories) -> Trajectories:
    """A vehicle's track until it leaves the map; of no steps if it is not there from the beginning."""
    return track.until(int(np.argmin(np.append(track.valid, False))))


def _lasts(holds: NDArray[np.bool_]) -> bool:
    """Whether something (T,) holds for LASTING steps running."""
    return bool((np.convolve(holds.astype(int), np.ones(LASTING, int)) == LASTING).any())


def _heads_along(route: Route, s: NDArray[np.float32], heading: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(T,) whether a vehicle at `s` (T,) heads as the route does there."""
    return np.asarray(np.abs(wrap_angle(heading - from_frenet(route, s, np.zeros_like(s))[1])) < ALONG)


def _changed(routes: Sequence[Route], track: Trajectories, side: float) -> NDArray[np.bool_]:
    """(T,) whether a vehicle is in the lane to a `side` of its own, and on none of the ways that its own leads on."""
    beside, on = np.zeros((2, track.steps), np.bool_)
    for route in routes:
        if route.lanes[0] == routes[0].lanes[0]:
            s, d = to_frenet(route, track.position).T
            along = _heads_along(route, s, track.heading)
            beside |= along & (side * d > CHANGED) & (side * d < FARTHER)
            on |= along & (np.abs(d) <= CHANGED)
    return beside & ~on


def _at_junction(
    manoeuvre: Manoeuvre,
    track: Trajectories,
    target_routes: Sequence[Route],
    own_routes: Sequence[Route],
    road_map: RoadMap,
    last: int,
) -> bool:
    """Whether a vehicle turns so at a junction, or gets over it without a turn, within its first `last` steps."""
    turn = _turned(track, road_map, last)
    if manoeuvre is Manoeuvre.GO_STRAIGHT:
        return bool(abs(turn) < TURNED) and _gets_over(own_routes, road_map, track, last)
    if manoeuvre is Manoeuvre.TURN_RIGHT:
        return bool(-U_TURN < turn < -TURNED)
    left = bool(TURNED < turn < U_TURN)
    if manoeuvre is Manoeuvre.TURN_LEFT:
        return left
    return left and any(_crosses(route, track, last) for route in target_routes)


def _turned(track: Trajectories, road_map: RoadMap, last: int) -> float:
    """How far [rad] a vehicle has turned to the left from its first junction to its last one; bends elsewhere are no turns.

    A way round a ring leads through several junctions: what it turns into and what it turns out of count together.
    """
    lane, _ = LaneGraph.of(road_map).nearest(track.position[:last], track.heading[:last], max_angle=ALIKE)
    inside = np.flatnonzero((lane != NO_LANE) & road_map.in_junction[lane])
    if not len(inside):
        return 0.0
    heading = np.unwrap(track.heading[:last].astype(np.float64))
    return float(heading[min(inside[-1] + AROUND, last - 1)] - heading[max(inside[0] - AROUND, 0)])


def _gets_over(routes: Sequence[Route], road_map: RoadMap, track: Trajectories, last: int) -> bool:
    """Whether a vehicle is beyond a junction on one of its own ways that others cross there."""
    across = crossed(road_map)
    for route in routes:
        s, d = to_frenet(route, track.position[:last]).T
        beyond = (np.abs(d) < OUT) & (s > end_of_crossing(route, road_map, across)) & (s < route.length)
        if (beyond & _heads_along(route, s, track.heading[:last])).any():
            return True
    return False


def _crosses(route: Route, track: Trajectories, last: int) -> bool:
    """Whether a vehicle gets from one side of a way that lies ahead to the other."""
    s, d = to_frenet(route, track.position).T
    return bool(((np.sign(d) != np.sign(d[0])) & (s > 0) & (s < route.length))[:last].any())


def _before_target(duty: Duty, track: Trajectories, target: Trajectories, route: Route, last: int) -> bool:
    """Cutting in and overtaking, measured along the target's way."""
    both = min(track.steps, target.steps)
    s, d = to_frenet(route, track.position[:both]).T
    own, _ = to_frenet(route, target.position[:both]).T
    if duty.manoeuvre is Manoeuvre.CUT_IN:
        along = _heads_along(route, s, track.heading[:both])
        before = (np.abs(d) < INTO) & (s > own) & along
        return bool(along[0] and OUT < abs(d[0]) < FARTHER) and _lasts(before[:last])
    if s[0] >= own[0]:
        return False
    passed = int(np.flatnonzero(s <= own + CLEAR)[-1]) + 1  # ahead from there to the end
    return passed < min(last, both) and bool(abs(d[passed]) < FARTHER)


def hardest_braking(track: Trajectories) -> NDArray[np.float32]:
    """(T - BRAKING_STEPS,) deceleration [m/s2] from each step on, over BRAKING_STEPS steps."""
    speed = track.speed
    return np.asarray((speed[:-BRAKING_STEPS] - speed[BRAKING_STEPS:]) / (BRAKING_STEPS * DT))
