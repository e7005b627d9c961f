"""Goals to leave by: when and where a vehicle leaves the map on its way to a candidate beyond an exit.

Such a candidate keeps its place straight on beyond the end of the road: ranking, labels and planning go by that. What is shown
of it (recordings, pictures, questions to language models) is where the vehicle is when its front is at the exit.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import DT, Scenario
from drivegen.goals.candidates import NO_ROUTE, SETTLE, Candidates
from drivegen.goals.outlook import distances
from drivegen.roads.frenet import from_frenet, to_frenet
from drivegen.roads.leaving import Exits
from drivegen.roads.line import Route

ON_ROUTE = 1.0
"""An exit is on a route whose line passes it within this distance [m]."""

STAYS_ON = np.float32(np.inf)
"""When a vehicle leaves that does not [s]."""


@dataclass(frozen=True)
class Departures:
    """How the C candidates of one vehicle are shown.

    Attributes:
        place: (C, 2) float32 [m] where it leaves the map, else the candidate's own place.
        way: (C,) float32 [m] along the route to there. speed: (C,) float32 [m/s] there.
        after: (C,) float32 [s] until it leaves as its outlook has it, STAYS_ON if it does not.
    """

    place: NDArray[np.float32]
    way: NDArray[np.float32]
    speed: NDArray[np.float32]
    after: NDArray[np.float32]

    @property
    def leaves(self) -> NDArray[np.bool_]:
        """(C,)."""
        return np.isfinite(self.after)


def departures(scenario: Scenario, vehicle: int, candidates: Candidates, exits: Exits) -> Departures:
    """Those of one vehicle's candidates; `exits` are those of the scenario's map."""
    half = float(scenario.vehicles.size[vehicle, 0]) / 2
    out = np.array([_exit(route, exits) - half for route in candidates.routes] + [np.inf])
    way = np.maximum(out[candidates.route], 0.0)  # the last is that of NO_ROUTE, -1
    shown = Departures(
        candidates.position.copy(), candidates.s.copy(), candidates.speed.copy(), np.full(len(way), STAYS_ON, np.float32)
    )
    rows = np.flatnonzero((candidates.route != NO_ROUTE) & (candidates.s > way))
    if len(rows):
        shown.after[rows], shown.speed[rows] = _passing(scenario, vehicle, candidates, rows, way[rows])
    for i in rows.tolist():
        number = int(candidates.route[i])
        d = float(candidates.offset[number]) * np.exp(-way[i] / SETTLE)
        shown.place[i], shown.way[i] = from_frenet(candidates.routes[number], way[i : i + 1], np.array([d]))[0][0], way[i]
    return shown


def _exit(route: Route, exits: Exits) -> float:
    """[m] along the route to the exit by which it leaves the map; inf where it ends before, wherever its last lane leads."""
    for point in exits.point[exits.lane == route.lanes[-1]]:
        s = to_frenet(route, point[None])[:, 0]
        if np.hypot(*(from_frenet(route, s, np.zeros(1))[0][0] - point)) < ON_ROUTE:
            return float(s[0])
    return np.inf


def _passing(
    scenario: Scenario, vehicle: int, c: Candidates, rows: NDArray[np.intp], way: NDArray[np.floating]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """When [s] and how fast [m/s] the outlooks towards candidates `rows` (R,) have come `way` (R,) [m]."""
    time = np.arange(scenario.steps) * DT
    start = np.full(len(rows), scenario.vehicles.speed[vehicle])
    gone = distances(time, np.maximum(c.step[rows], 1) * DT, c.s[rows], start, c.speed[rows])
    step = np.argmax(gone >= way[:, None], axis=1).clip(1)
    row = np.arange(len(rows))
    before, after = gone[row, step - 1], gone[row, step]
    share = np.clip((way - before) / np.maximum(after - before, 1e-6), 0.0, 1.0)
    return ((step - 1 + share) * DT).astype(np.float32), ((after - before) / DT).astype(np.float32)
