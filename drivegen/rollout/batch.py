"""Scenario rollout: goals drawn, motion planned, legality checked, the illegal planned again (paper, section III-C).

All vehicles of all samples of all scenarios are planned in one batch; then each sample's vehicles are committed in
asset order, each against those committed before it, and what was illegal is planned again in the next round (`rollout`).
The paper does the same one vehicle at a time; the batch turns sixteen times ten planner calls per scenario into a few for
thousands of scenarios.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.core import seeds
from drivegen.core.geometry import unit
from drivegen.core.rejections import Rejections
from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, Trajectories
from drivegen.goals.candidates import Candidates
from drivegen.planners.base import Planner, PlanRequests
from drivegen.planners.shared.noise import GOLDEN, mixed
from drivegen.planners.shared.requests import Goals, moved, plan_requests
from drivegen.roads.line import Route
from drivegen.rollout.choices import Choices
from drivegen.rollout.scene import Rollout, RolloutSettings

BRAKING = 4.0
"""[m/s2] Who varies a goal, or is to stay while it rolls, brakes by this at most, in the mean over the way to a standstill."""


def roll_out(
    choices: Sequence[Choices],
    planner: Planner,
    limits: Limits,
    settings: RolloutSettings,
    samples: int,
    seed: int,
    method: str,
    targets: Sequence[Trajectories] | None = None,
    rejections: Mapping[str, Rejections] | None = None,
) -> list[Samples]:
    """K = `samples` futures of every scenario; the result for one depends on it and the seed alone.

    `targets`, if given, are the targets' motions (K, T), known beforehand: only the others are planned. `rejections`, by
    scenario, are told what is turned down in theirs.
    """
    motions = targets if targets is not None else [None] * len(choices)
    noted = [(rejections or {}).get(choice.scenario.scenario_id) for choice in choices]
    rollouts = [
        Rollout(choice, limits, settings, samples, seed, at, note)
        for choice, at, note in zip(choices, motions, noted, strict=True)
    ]
    for turn in range(settings.rounds):
        rows_of = [rollout.rows_to_plan(turn) for rollout in rollouts]
        if not any(len(w) for w in rows_of):
            break
        for rollout, rows, motion in _plan(rollouts, rows_of, planner, seed, turn):
            rollout.commit(rows, motion)
    return [rollout.result(method) for rollout in rollouts]


def _plan(
    rollouts: list[Rollout], rows_of: list[NDArray[np.int64]], planner: Planner, seed: int, turn: int
) -> list[tuple[Rollout, NDArray[np.int64], Trajectories]]:
    """Plan what all scenarios want in one call and hand each its own part."""
    choices = [r.choice for r in rollouts]
    requests = goal_requests(choices, rows_of, lambda s: seeds.derive(seed, "plan", choices[s].scenario.scenario_id, turn))
    motion = planner.sample([c.scenario for c in choices], requests)
    ends = np.cumsum([0, *map(len, rows_of)])
    return [
        (rollout, rows, motion[a:b].until(rollout.choice.scenario.steps))
        for rollout, rows, a, b in zip(rollouts, rows_of, ends[:-1], ends[1:], strict=True)
        if len(rows)
    ]


def goal_requests(
    choices: Sequence[Choices], rows_of: Sequence[NDArray[np.int64]], base_seed: Callable[[int], int]
) -> PlanRequests:
    """Plan requests for rows (sample, vehicle, candidate, attempt) of every scenario.

    The seed of a request mixes the scenario's with the row, so it does not depend on what else is wanted.
    """
    if not choices:
        return PlanRequests.none()
    routes: list[Route] = []
    columns: list[tuple[NDArray[np.generic], ...]] = []
    noise: list[NDArray[np.int64]] = []
    for s, (choice, rows) in enumerate(zip(choices, rows_of, strict=True)):
        table = _GoalTable.of(choice.candidates, len(routes))
        routes.extend(route for cands in choice.candidates for route in cands.routes)
        pick = table.start[rows[:, 1]] + rows[:, 2]
        columns.append((np.full(len(rows), s), rows[:, 1], *(column[pick] for column in table.columns)))
        noise.append(_row_seeds(base_seed(s), rows))
    goals = Goals(*map(np.concatenate, zip(*columns, strict=True)))
    used, route = _in_use(goals.route)
    scenarios = [choice.scenario for choice in choices]
    requests = plan_requests(scenarios, [routes[r] for r in used], replace(goals, route=route), np.concatenate(noise))
    return _with_room_to_stop(requests)


def _with_room_to_stop(requests: PlanRequests) -> PlanRequests:
    """Who is to stay but still rolls stops as soon as a body on wheels can, a little farther on: nobody stands at once."""
    room = np.minimum(requests.speed**2 / (2 * BRAKING), requests.speed * requests.goal_step * np.float32(DT))
    rolls_on = room * (requests.goal_s <= 0)
    there = (requests.route < 0) & (requests.goal_position == requests.position).all(axis=1)
    ahead = np.where(there[:, None], rolls_on[:, None] * unit(requests.heading), 0.0)
    requests = replace(requests, goal_position=(requests.goal_position + ahead).astype(np.float32))
    return moved(requests, rolls_on, np.zeros_like(rolls_on), np.zeros_like(rolls_on))


def _in_use(route: NDArray[np.integer]) -> tuple[list[int], NDArray[np.int64]]:
    """The routes that are asked for, and `route` (B,) in numbers of these: most candidates' routes are followed by nobody."""
    used = np.unique(route[route >= 0])
    return used.tolist(), np.where(route >= 0, np.searchsorted(used, route), -1)


@dataclass(frozen=True)
class _GoalTable:
    """All candidates of a scenario one below the other; vehicle n's begin at `start[n]`."""

    start: NDArray[np.int64]
    columns: tuple[NDArray[np.generic], ...]

    @classmethod
    def of(cls, candidates: list[Candidates], first_route: int) -> "_GoalTable":
        """Route numbers count on from `first_route`; -1 stays where a candidate has none."""
        start = np.cumsum([0, *map(len, candidates)])
        route_start = first_route + np.cumsum([0, *(len(c.routes) for c in candidates)])[:-1]
        route = [np.where(c.route < 0, -1, c.route + first) for c, first in zip(candidates, route_start, strict=True)]
        names = ("position", "heading", "speed", "step", "s", "d")
        position, heading, speed, step, s, d = (np.concatenate([getattr(c, name) for c in candidates]) for name in names)
        return cls(start, (position, heading, speed, step, np.concatenate(route), s, d))


def _row_seeds(seed: int, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """A 63-bit seed per row, from `seed` and the row's digits."""
    with np.errstate(over="ignore"):
        digits = rows.astype(np.uint64) @ np.array([1 << 40, 1 << 24, 1 << 8, 1], np.uint64)
        state = np.uint64(seed) + digits * GOLDEN
    return (mixed(state) >> np.uint64(1)).astype(np.int64)
