"""Motion towards all goals of all vehicles at once, and towards places near chosen ones: nothing drawn, nothing checked."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.scenario import DT, Trajectories
from drivegen.core.settings import NotNegative
from drivegen.planners.base import Planner, PlanRequests
from drivegen.planners.shared.noise import normals
from drivegen.planners.shared.requests import moved
from drivegen.roads.leaving import Exits
from drivegen.roads.reach import stopping_distance
from drivegen.rollout.batch import BRAKING, goal_requests
from drivegen.rollout.choices import Choices

NEAR = 1 << 20
"""The stream of noise that places near a goal are drawn from, apart from that of the motion towards them."""


def plan_all_goals(choices: Sequence[Choices], planner: Planner, seed: int) -> list[Trajectories]:
    """One trajectory towards every candidate, until it leaves the map: (sum of C, T) per scenario, vehicle by vehicle."""
    rows_of = [
        np.array([(0, n, c, 0) for n, cands in enumerate(choice.candidates) for c in range(len(cands))], np.int64).reshape(-1, 4)
        for choice in choices
    ]
    requests = goal_requests(choices, rows_of, lambda s: seeds.derive(seed, "all-goals", choices[s].scenario.scenario_id))
    return _planned(choices, rows_of, requests, planner)


@dataclass(frozen=True)
class Spread:
    """Standard deviations of places around a goal: `along` its route [m], `across` it [m], and of the `speed` there [m/s]."""

    along: NotNegative
    across: NotNegative
    speed: NotNegative


def plan_near_goals(
    choices: Sequence[Choices], rows_of: Sequence[NDArray[np.int64]], spread: Spread, planner: Planner, seed: int
) -> list[Trajectories]:
    """One trajectory towards a place near a candidate's for each row (number, vehicle, candidate, 0): (rows, T) per scenario.

    Who gets farther on the same way, or is faster at its end, passes everything on it at other times. No place is nearer than
    its vehicle can stop: a planner would let it stand at once. A place depends on its row, the scenario and the seed alone.
    """
    requests = goal_requests(choices, rows_of, lambda s: seeds.derive(seed, "near-goals", choices[s].scenario.scenario_id))
    along, across, speed, _ = normals(requests.seed, 4, NEAR).T
    farther = np.maximum(spread.along * along, np.minimum(_stopping(requests) - requests.goal_s, 0.0))
    requests = moved(requests, farther, spread.across * across, spread.speed * speed)
    return _planned(choices, rows_of, requests, planner)


def _stopping(requests: PlanRequests) -> NDArray[np.float64]:
    """(B,) [m] the least distance in which vehicles stop."""
    speeds = zip(requests.speed.tolist(), (requests.goal_step * DT).tolist(), strict=True)
    return np.array([stopping_distance(speed, BRAKING, seconds) for speed, seconds in speeds])


def _planned(
    choices: Sequence[Choices], rows_of: Sequence[NDArray[np.int64]], requests: PlanRequests, planner: Planner
) -> list[Trajectories]:
    """Motion for requests, as many as there are rows, until it leaves the map: (rows, T) per scenario."""
    motion = planner.sample([c.scenario for c in choices], requests)
    ends = np.cumsum([0, *map(len, rows_of)])
    return [
        _on_the_map(choice, rows[:, 1], motion[a:b])
        for choice, rows, a, b in zip(choices, rows_of, ends[:-1], ends[1:], strict=True)
    ]


def _on_the_map(choice: Choices, vehicle: NDArray[np.int64], motion: Trajectories) -> Trajectories:
    """Planned motion (B, T) of the vehicles (B,), gone where it leaves the map."""
    scenario = choice.scenario
    return Exits.of(scenario.map).leave(motion.until(scenario.steps), scenario.vehicles.size[vehicle, 0])
