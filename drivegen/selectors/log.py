"""The true goal, read from the log: an upper bound for every selector, not a method.

The logged end state itself is added to each vehicle's candidates, with the route that the log really followed, and gets
all the probability: the planner is given the true goal, not the candidate nearest to it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import NO_LANE
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.goals.candidates import NO_ROUTE, Candidates
from drivegen.goals.manoeuvres import manoeuvres
from drivegen.goals.traffic import Neighbours, look_ahead
from drivegen.roads.frenet import to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import SPACING
from drivegen.roads.routes import match_route
from drivegen.selectors.base import Untrained


class Plugin(Untrained):
    """All probability on the logged end state at the last valid step."""

    described = "the log's own goal (upper bound)"
    reads_log = True

    def offer(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[Candidates]:
        """The given candidates, and the logged end of each vehicle as the last one.

        Raises UnusableInput where the scenario has no log.
        """
        if scenario.log is None:
            raise UnusableInput(f"scenario {scenario.scenario_id} has no log to take goals from", reason="no-log")
        return [_with_logged_end(graph, scenario, n, c) for n, c in enumerate(candidates)]

    def rank(
        self,
        graph: LaneGraph,  # noqa: ARG002 protocol
        scenario: Scenario,
        candidates: Sequence[Candidates],
    ) -> list[NDArray[np.float32]]:
        """1 for the candidate at the logged end, else 0; the nearest one if `offer` was not asked."""
        if scenario.log is None:
            raise UnusableInput(f"scenario {scenario.scenario_id} has no log to take goals from", reason="no-log")
        ends = logged_ends(scenario.log)
        return [_nearest(c, end) for c, end in zip(candidates, ends, strict=True)]


def logged_ends(log: Trajectories) -> NDArray[np.float32]:
    """Position (N, 2) of each vehicle at its last valid step."""
    ends: NDArray[np.float32] = log.position[np.arange(len(log.valid)), log.last_valid()]
    return ends


def _nearest(candidates: Candidates, end: NDArray[np.float32]) -> NDArray[np.float32]:
    gap = np.hypot(*(candidates.position - end).T)
    nearest = len(gap) - 1 - int(np.argmin(gap[::-1]))  # the added one where it coincides with another
    probability = np.zeros(len(gap), np.float32)
    probability[nearest] = 1.0
    return probability


def _with_logged_end(graph: LaneGraph, scenario: Scenario, vehicle: int, given: Candidates) -> Candidates:
    assert scenario.log is not None
    track = scenario.log[vehicle]
    last, seen = int(track.last_valid()), track.valid
    position = track.position[last]
    route = match_route(graph, track.position[seen], track.heading[seen], kind=int(scenario.vehicles.kind[vehicle]))
    if route is None:
        s, d, number, lane, leaves = 0.0, 0.0, NO_ROUTE, NO_LANE, False
        kind = manoeuvres(None, 0.0, float(track.speed[last]))
    else:
        s, d = to_frenet(route, position[None])[0]
        number, leaves = len(given.routes), bool(s > route.exit_s)
        lane = int(route.lane[min(max(int(s / SPACING), 0), len(route.lane) - 1)])
        kind = manoeuvres(route, float(s), float(track.speed[last]))
        start = scenario.vehicles.position[vehicle]
        around = Neighbours.of(scenario, vehicle).near(start, route.length + 20.0)
        given = replace(
            given,
            routes=(*given.routes, route),
            ahead=(*given.ahead, look_ahead(scenario, route, around, float(scenario.vehicles.size[vehicle, 0]))),
            offset=np.append(given.offset, to_frenet(route, start[None])[0, 1]),
        )
    return given.with_more(
        position=[position],
        heading=[track.heading[last]],
        speed=[track.speed[last]],
        route=[number],
        s=[s],
        d=[d],
        step=[max(last, 1)],  # of who was seen once
        manoeuvre=[kind],
        lane=[lane],
        leaves_map=[leaves],
        prior=[0.0],
    )
