"""What a ranker is told of each candidate: geometry, what it takes to get there, what is in the way, what kind it is."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.geometry import to_vehicle_frame, wrap_angle
from drivegen.goals.candidates import Candidates, Manoeuvre
from drivegen.scenario import DT, Scenario, VehicleKind

FAR = 100.0
"""Distances are cut off here [m]: what is farther ahead hardly matters."""

CROWD = 30.0
"""Vehicles within this distance [m] are counted as near."""

NAMES = (
    "ahead", "left", "cos_heading", "sin_heading", "distance", "along", "across", "mean_speed", "acceleration", "end_speed",
    "speed", "standing", "limit", "limit_known", "speed_over_limit", "end_over_limit", "lane_changes", "turned",
    "start_offset", "leader_gap", "leader_speed", "leader_standing", "beyond_leader", "red_ahead", "beyond_red",
    "junction_ahead", "beyond_junction", "room_at_end", "neighbours", "leaves_map", "off_lane", "log_prior",
    "length", "heavy", "seconds", *(kind.name.lower() for kind in Manoeuvre),
)  # fmt: skip
"""One name per column."""


def features(scenario: Scenario, candidates: Sequence[Candidates]) -> list[NDArray[np.float32]]:
    """(C, len(NAMES)) float32 for each vehicle of the scenario, from the first frame; all about within [-3, 3]."""
    return [_of_vehicle(scenario, vehicle, c) for vehicle, c in enumerate(candidates)]


def _of_vehicle(scenario: Scenario, vehicle: int, c: Candidates) -> NDArray[np.float32]:
    v = scenario.vehicles
    speed, seconds = float(v.speed[vehicle]), max(float(c.step.max()) * DT, DT)
    local = to_vehicle_frame(c.position, v.position[vehicle], v.heading[vehicle])
    turn = wrap_angle(c.heading - v.heading[vehicle])
    distance = np.hypot(*local.T)
    on_route = c.route >= 0
    along = np.where(on_route, c.s, distance)
    route = _of_routes(c)[np.where(on_route, c.route, len(c.routes))]
    limit, gap, leader, red, junction, changes, turned, offset = route.T
    known = limit > 0
    pace = along / seconds
    others = np.arange(len(v)) != vehicle
    room = np.full(len(c), FAR)
    if others.any():
        room = np.hypot(*(c.position[:, None] - v.position[others]).transpose(2, 0, 1)).min(1)
    near = np.hypot(*(v.position[others] - v.position[vehicle]).T) < CROWD
    one = np.ones(len(c))
    columns = [
        local[:, 0] / 50, local[:, 1] / 20, np.cos(turn), np.sin(turn), distance / 50, along / 50, c.d / 3, pace / 10,
        2 * (pace - speed) / seconds / 2, c.speed / 10, one * speed / 10, one * (speed < 0.5), limit / 10, known,
        speed / np.where(known, limit, 15.0), c.speed / np.where(known, limit, 15.0), changes, turned, offset,
        np.minimum(gap, FAR) / 30, leader / 10, (gap < FAR) & (leader < 1.0),
        np.clip((along - gap - leader * seconds) / 30, -3, 3), np.minimum(red, FAR) / 30, along > red + 3,
        np.minimum(junction, FAR) / 30, along > junction + 3, np.minimum(room, 30.0) / 10, one * near.sum() / 5, c.leaves_map,
        ~on_route, np.log(c.prior + 1e-4) / 2, one * v.size[vehicle, 0] / 5,
        one * (v.kind[vehicle] in (VehicleKind.TRUCK, VehicleKind.BUS)), one * seconds / 10,
        *(c.manoeuvre == kind for kind in Manoeuvre),
    ]  # fmt: skip
    return np.column_stack(columns).astype(np.float32)


def _of_routes(c: Candidates) -> NDArray[np.float64]:
    """(R + 1, 8) numbers of each route, and those of no route in the last row."""
    rows = [
        (
            np.nan_to_num(float(route.speed_limit[0])),
            ahead.leader_gap,
            ahead.leader_speed,
            ahead.red_s,
            ahead.entry_s,
            route.lane_changes,
            float(route.turned[-1]),
            float(np.clip(offset, -4, 4)),
        )
        for route, ahead, offset in zip(c.routes, c.ahead, c.offset, strict=True)
    ]
    return np.array([*rows, (0.0, 1e3, 0.0, 1e3, 1e3, 0.0, 0.0, 4.0)]).clip(-1e3, 1e3)
