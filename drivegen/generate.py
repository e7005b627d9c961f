"""Scenario rollout: goals drawn, motion planned, legality checked, the illegal planned again (paper, section III-C).

All vehicles of all samples of all scenarios are planned in one batch; then each sample's vehicles are committed in
asset order, each against those committed before it. What was illegal is planned again in the next round, first towards
the same goal, then towards the next ones. The paper does the same one vehicle at a time; the batch turns sixteen times
ten planner calls per scenario into a few for thousands of scenarios.

Asset order alone leaves dead ends: whoever is committed first may run over the place of a vehicle that is planned later
and can't get out of its way. Such a vehicle takes its best trajectory that is legal but for collisions, and those that it
collides with are planned again, a bounded number of times.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivegen import seeds
from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.errors import UnusableInput
from drivegen.goals.candidates import Candidates, candidates
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.packing import unpack
from drivegen.lanes.graph import LaneGraph
from drivegen.lanes.routes import Route
from drivegen.planners._requests import Goals, plan_requests
from drivegen.planners.base import Planner, PlanRequests
from drivegen.samples import NO_GOAL, Samples, Violation
from drivegen.scenario import TARGET, Scenario, Trajectories
from drivegen.selectors.base import Selector
from drivegen.store.goals import GoalColumns

Probabilities = list[NDArray[np.float32]]
"""One array (C,) per vehicle of a scenario, over its candidates."""


@dataclass(frozen=True)
class RolloutSettings:
    """How often the illegal is planned again, and what becomes of what stays illegal.

    Attributes:
        attempts: trajectories planned for a pending vehicle in each round after the first.
        rounds: number of rounds, the first included.
        evictions: how often a vehicle may be planned again because another one found no way past it.
        drop_illegal: leave out vehicles that could not be made legal; else the least illegal trajectory stays.
        target_steps: others avoid the target's planned motion up to this step only, None for always. In corner cases
            its driver has to react, and this is the time that it is given.
    """

    attempts: int
    rounds: int
    evictions: int
    drop_illegal: bool
    target_steps: int | None


@dataclass(frozen=True)
class Choices:
    """A scenario with the goals that its vehicles may take.

    Attributes:
        scenario: the scenario, N vehicles.
        candidates: N Candidates.
        natural: N arrays (C,), the selector's own probabilities.
        used: N arrays (C,), those that goals are drawn with.
    """

    scenario: Scenario
    candidates: list[Candidates]
    natural: Probabilities
    used: Probabilities


def choose(scenarios: Sequence[Scenario], selector: Selector, settings: CandidateSettings, temperature: float) -> list[Choices]:
    """Candidates and probabilities of all vehicles of all scenarios; goals are drawn from the tempered ones."""
    choices = []
    for scenario in scenarios:
        graph = LaneGraph.of(scenario.map)
        found = [candidates(graph, scenario, n, settings) for n in range(len(scenario.vehicles))]
        offered = selector.offer(graph, scenario, found)
        natural = selector.rank(graph, scenario, offered)
        choices.append(Choices(scenario, offered, natural, tempered(natural, temperature)))
    return choices


def recorded_choices(scenarios: Sequence[Scenario], goals: Sequence[GoalColumns], temperature: float) -> list[Choices]:
    """As `choose`, from what the goals stage recorded for the same scenarios.

    Raises UnusableInput where they are not the same.
    """
    if [s.scenario_id for s in scenarios] != [g.scenario_id for g in goals]:
        raise UnusableInput("the recorded goals belong to other scenarios: run the goals stage again")
    choices = []
    for scenario, columns in zip(scenarios, goals, strict=True):
        offered, natural = unpack(LaneGraph.of(scenario.map), columns)
        choices.append(Choices(scenario, offered, natural, tempered(natural, temperature)))
    return choices


def judged(scenario: Scenario, samples: Samples, limits: Limits) -> Samples:
    """The samples with the checker's verdicts on them as they stand, both partners of a collision charged."""
    violation, first = SceneChecker(scenario, limits).check_samples(samples.motion)
    return replace(samples, violation=violation, first_violation=first)


def tempered(probabilities: Probabilities, temperature: float) -> Probabilities:
    """`p ** (1 / temperature)`, normalised: below 1 the likely goals gain, above 1 the unlikely ones."""
    powers = [p.astype(np.float64) ** (1.0 / temperature) for p in probabilities]
    return [(p / p.sum()).astype(np.float32) for p in powers]


def roll_out(
    choices: Sequence[Choices], planner: Planner, limits: Limits, settings: RolloutSettings, samples: int, seed: int, method: str
) -> list[Samples]:
    """K = `samples` futures of every scenario; the result for one depends on it and the seed alone."""
    rollouts = [_Rollout(choice, limits, settings, samples, seed) for choice in choices]
    for turn in range(settings.rounds):
        attempts = 1 if turn == 0 else settings.attempts
        wanted = [rollout.wanted(turn, attempts) for rollout in rollouts]
        if not any(len(w) for w in wanted):
            break
        for rollout, rows, motion in _plan(rollouts, wanted, planner, seed, turn):
            rollout.commit(rows, motion)
    return [rollout.result(method) for rollout in rollouts]


def plan_all_goals(choices: Sequence[Choices], planner: Planner, seed: int) -> list[Trajectories]:
    """One trajectory towards every candidate: (sum of C, T) per scenario, vehicle by vehicle in asset order."""
    wanted = [
        np.array([(0, n, c, 0) for n, cands in enumerate(choice.candidates) for c in range(len(cands))], np.int64).reshape(-1, 4)
        for choice in choices
    ]
    requests = _requests(choices, wanted, lambda s: seeds.derive(seed, "all-goals", choices[s].scenario.scenario_id))
    motion = planner.sample([c.scenario for c in choices], requests)
    ends = np.cumsum([0, *map(len, wanted)])
    return [motion[a:b].until(choice.scenario.steps) for choice, a, b in zip(choices, ends[:-1], ends[1:], strict=True)]


def _plan(
    rollouts: "list[_Rollout]", wanted: list[NDArray[np.int64]], planner: Planner, seed: int, turn: int
) -> "list[tuple[_Rollout, NDArray[np.int64], Trajectories]]":
    """Plan what all scenarios want in one call and hand each its own part."""
    choices = [r.choice for r in rollouts]
    requests = _requests(choices, wanted, lambda s: seeds.derive(seed, "plan", choices[s].scenario.scenario_id, turn))
    motion = planner.sample([c.scenario for c in choices], requests)
    ends = np.cumsum([0, *map(len, wanted)])
    return [
        (rollout, rows, motion[a:b].until(rollout.choice.scenario.steps))
        for rollout, rows, a, b in zip(rollouts, wanted, ends[:-1], ends[1:], strict=True)
        if len(rows)
    ]


def _requests(choices: Sequence[Choices], wanted: list[NDArray[np.int64]], base_seed: Callable[[int], int]) -> PlanRequests:
    """Plan requests for rows (sample, vehicle, candidate, attempt) of every scenario.

    The seed of a request mixes the scenario's with the row, so it does not depend on what else is wanted.
    """
    routes: list[Route] = []
    columns: list[tuple[NDArray[np.generic], ...]] = []
    noise: list[NDArray[np.int64]] = []
    for s, (choice, rows) in enumerate(zip(choices, wanted, strict=True)):
        table = _GoalTable.of(choice.candidates, len(routes))
        routes.extend(route for cands in choice.candidates for route in cands.routes)
        pick = table.start[rows[:, 1]] + rows[:, 2]
        columns.append((np.full(len(rows), s), rows[:, 1], *(column[pick] for column in table.columns)))
        noise.append(_mixed(base_seed(s), rows))
    goals = Goals(*map(np.concatenate, zip(*columns, strict=True)))
    return plan_requests([choice.scenario for choice in choices], routes, goals, np.concatenate(noise))


@dataclass(frozen=True)
class _GoalTable:
    """All candidates of a scenario one below the other; vehicle n's begin at `start[n]`."""

    start: NDArray[np.int64]
    columns: tuple[NDArray[np.generic], ...]

    @classmethod
    def of(cls, candidates: list[Candidates], first_route: int) -> "_GoalTable":
        """Route numbers count on from `first_route`; -1 stays where a candidate has none."""
        start = np.cumsum([0, *map(len, candidates)])
        route_start = first_route + np.cumsum([0, *(len(c.routes) for c in candidates)])
        route = [np.where(c.route < 0, -1, c.route + first) for c, first in zip(candidates, route_start, strict=False)]
        names = ("position", "heading", "speed", "step", "s", "d")
        position, heading, speed, step, s, d = (np.concatenate([getattr(c, name) for c in candidates]) for name in names)
        return cls(start, (position, heading, speed, step, np.concatenate(route), s, d))


def _mixed(seed: int, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """A 63-bit number per row: SplitMix64's finaliser over the seed and the row's digits."""
    with np.errstate(over="ignore"):
        digits = rows.astype(np.uint64) @ np.array([1 << 40, 1 << 24, 1 << 8, 1], np.uint64)
        z = np.uint64(seed) + digits * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z = z ^ (z >> np.uint64(31))
    return (z >> np.uint64(1)).astype(np.int64)


class _Rollout:
    """One scenario on its way: what is committed, what is pending, and the best of what was illegal so far.

    `motion` (K, N, T) holds committed vehicles only (valid False elsewhere), `spare` the least illegal trajectory of
    each pending one, `order` (K, N, C) the candidates in the order in which sample k tries them for vehicle n.
    """

    def __init__(self, choice: Choices, limits: Limits, settings: RolloutSettings, samples: int, seed: int) -> None:
        scenario, count = choice.scenario, len(choice.scenario.vehicles)
        self.choice, self.settings, self.turn = choice, settings, 0
        self.checker = SceneChecker(scenario, limits)
        self.motion = Trajectories.empty(samples, count, scenario.steps)
        self.spare = Trajectories.empty(samples, count, scenario.steps)
        self.badness = np.full((samples, count), np.inf)
        self.pending = np.ones((samples, count), np.bool_)
        self.goal = np.full((samples, count), NO_GOAL, np.int32)
        self.attempts = np.zeros((samples, count), np.int64)
        self.evictions = np.zeros((samples, count), np.int64)
        self.tried = np.zeros((samples, count), np.int64)
        self.order = [_drawing_order(choice.used[n], samples, seed, scenario.scenario_id, n) for n in range(count)]

    def wanted(self, turn: int, attempts: int) -> NDArray[np.int64]:
        """Rows (sample, vehicle, candidate, attempt): the same goal once more, then the next ones in drawing order."""
        self.turn = turn
        rows: list[tuple[int, int, int, int]] = []
        for k, n in np.argwhere(self.pending):
            order = self.order[n][k]
            again = max(int(self.tried[k, n]) - 1, 0)
            first = again * (attempts - 1) + (again > 0)
            rows.extend((int(k), int(n), int(order[min(first + a, len(order) - 1)]), turn * 16 + a) for a in range(attempts))
        self.tried += self.pending
        return np.array(rows, np.int64).reshape(-1, 4)

    def commit(self, rows: NDArray[np.int64], motion: Trajectories) -> None:
        """Walk each sample's pending vehicles in asset order; commit the first legal trajectory of each."""
        size = self.choice.scenario.vehicles.size[:, :2]
        starts = np.flatnonzero(np.any(np.diff(rows[:, :2], axis=0, prepend=-1) != 0, axis=1))
        for a, b in zip(starts, [*starts[1:], len(rows)], strict=True):
            k, n = rows[a, 0], rows[a, 1]
            others = self.motion[k]
            if self.settings.target_steps is not None and n != TARGET:
                others = _target_until(others, self.settings.target_steps)
            violation, first = self.checker.check(int(n), motion[a:b], others, size)
            self._judge(int(k), int(n), rows[a:b, 2], motion[a:b], violation, first)

    def _judge(
        self,
        k: int,
        n: int,
        candidate: NDArray[np.int64],
        motion: Trajectories,
        violation: NDArray[np.uint16],
        first: NDArray[np.int16],
    ) -> None:
        legal = np.flatnonzero(violation == 0)
        if len(legal):
            self.attempts[k, n] += int(legal[0]) + 1
            self._settle(k, n, candidate[legal[0]], motion[int(legal[0])])
            return
        self.attempts[k, n] += len(violation)
        blocked = np.flatnonzero(violation == Violation.COLLISION)
        if len(blocked) and self._evict(k, n, motion[int(blocked[0])]):
            self._settle(k, n, candidate[blocked[0]], motion[int(blocked[0])])
            return
        badness = _badness(violation, first, motion.steps)
        chosen = int(badness.argmin())
        if badness[chosen] < self.badness[k, n]:
            self.badness[k, n], self.goal[k, n] = badness[chosen], candidate[chosen]
            _put(self.spare, (k, n), motion[chosen])

    def _settle(self, k: int, n: int, candidate: np.int64, motion: Trajectories) -> None:
        self.pending[k, n], self.goal[k, n] = False, candidate
        _put(self.motion, (k, n), motion)

    def _evict(self, k: int, n: int, motion: Trajectories) -> bool:
        """Make way for a trajectory that only collides: whether all in its way could be sent to the next round."""
        if self.turn + 1 == self.settings.rounds:
            return False
        others = np.flatnonzero(self.checker.partners(n, motion, self.motion[k]))
        if (self.evictions[k, others] >= self.settings.evictions).any() or len(others) == 0:
            return False
        self.evictions[k, others] += 1
        self.tried[k, others] = 1
        self.pending[k, others] = True
        for other in others.tolist():
            _put(self.spare, (k, other), self.motion[k, other])
            self.badness[k, other] = 1.0
        self.motion.valid[k, others] = False
        return True

    def result(self, method: str) -> Samples:
        """The samples as they stand: pending vehicles keep their least illegal trajectory or are dropped.

        Everything is judged once more together, so that a collision is charged to both partners.
        """
        left = self.pending
        if not self.settings.drop_illegal:
            for k, n in np.argwhere(left):
                _put(self.motion, (k, n), self.spare[k, n])
        violation, first = self.checker.check_samples(self.motion, self.settings.target_steps is not None)
        natural, used = (self._probability(p) for p in (self.choice.natural, self.choice.used))
        return Samples(
            scenario_id=self.choice.scenario.scenario_id,
            method=method,
            motion=self.motion,
            violation=violation,
            first_violation=first,
            goal=self.goal,
            natural=natural,
            used=used,
            attempts=np.minimum(self.attempts, 255).astype(np.uint8),
            dropped=left if self.settings.drop_illegal else np.zeros_like(left),
        )

    def _probability(self, probabilities: Probabilities) -> NDArray[np.float32]:
        columns = [p[self.goal[:, n]] for n, p in enumerate(probabilities)]
        return np.stack(columns, axis=1).astype(np.float32)


def _drawing_order(used: NDArray[np.float32], samples: int, seed: int, scenario_id: str, vehicle: int) -> NDArray[np.intp]:
    """Candidates (K, C) in the order of draws without replacement from `used` (Gumbel top-k)."""
    noise = seeds.rng(seed, "goals", scenario_id, vehicle).gumbel(size=(samples, len(used)))
    return np.argsort(-(np.log(np.maximum(used, 1e-12)) + noise), axis=1, kind="stable")


def _badness(violation: NDArray[np.uint16], first: NDArray[np.int16], steps: int) -> NDArray[np.float64]:
    """Fewer broken rules are better; among equals, the later the first one breaks the better."""
    rules = np.array([int(v).bit_count() for v in violation], np.float64)
    return rules + 1.0 - first / steps


def _target_until(motion: Trajectories, steps: int) -> Trajectories:
    valid = motion.valid.copy()
    valid[TARGET, steps:] = False
    return Trajectories(motion.position, motion.heading, motion.velocity, valid)


def _put(into: Trajectories, index: tuple[int, int], motion: Trajectories) -> None:
    into.position[index], into.heading[index] = motion.position, motion.heading
    into.velocity[index], into.valid[index] = motion.velocity, motion.valid
