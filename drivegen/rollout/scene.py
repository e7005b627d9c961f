"""One scenario during the rollout: goals are drawn together, motion is committed, illegal motion is planned again.

The first goals of a sample are drawn for all vehicles together (`goals.joint`), so that a follower does not end beyond its
leader. Vehicles are committed in asset order, each against those before it; an illegal vehicle is planned again in the
next round, towards goals drawn by its own odds (without the common tempo) among those whose outlook is clear of committed motion.
Asset order alone leads into dead ends: a committed vehicle may drive over the place of one that is planned later and
cannot get out. Such a vehicle takes its best trajectory that is legal but for collisions, and those that it collides with are
planned again, a bounded number of times. So are those who turn out to owe the way to somebody that was committed after them.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import FLAGS, YIELD_GAP, Limits
from drivegen.checker.scene import SceneChecker, Severities
from drivegen.core.geometry import to_vehicle_frame, wrap_angle
from drivegen.core.rejections import Rejections
from drivegen.core.samples import NO_GOAL, Samples, Violation
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.core.settings import Index, Within
from drivegen.roads.leaving import Exits
from drivegen.rollout.choices import Choices, Probabilities
from drivegen.rollout.draws import GoalDraws

MOST = 16
"""Rounds, and attempts in each, at most: an attempt's number has eight bits of its request's seed (`batch._row_seeds`)."""

ALIKE = np.pi / 3
"""Headings that differ by less [rad] are one direction of travel."""


@dataclass(frozen=True)
class RolloutSettings:
    """How often the illegal is planned again, and what becomes of what stays illegal.

    Attributes:
        attempts: trajectories planned for a pending vehicle in each round after the first.
        rounds: number of rounds, the first included.
        evictions: how often a vehicle may be planned again because another one found no way past it.
        drop_illegal: leave out vehicles that could not be made legal; else the least illegal trajectory stays.
        target_steps: others avoid the target's planned motion up to this step only, None for always. In corner cases
            its driver has to react, and this is the time that it is given. Who comes from behind avoids it always: a
            replayed vehicle that runs into the target's rear asks nothing of its driver.
        exclusion: whether goals of a sample exclude one another (`goals.joint`); else each vehicle draws its own.
        tempo: share of the variance of ranks that the vehicles of a sample have in common (`goals.joint`).
    """

    attempts: Annotated[int, Within(1, MOST)]
    rounds: Annotated[int, Within(1, MOST)]
    evictions: Index
    drop_illegal: bool
    target_steps: Index | None
    exclusion: bool
    tempo: Annotated[float, Within(0.0, 0.95)]


class Rollout:
    """What is committed, what is pending, and the best of what was illegal so far.

    `motion` (K, N, T) holds committed vehicles only (valid False elsewhere), `spare` the least illegal trajectory of
    each pending one. Where the motion of the `target` (K, T) is known, it stands from the beginning and is neither planned nor
    moved aside. What is turned down is noted in `rejections`, if given.
    """

    def __init__(
        self,
        choice: Choices,
        limits: Limits,
        settings: RolloutSettings,
        samples: int,
        seed: int,
        target: Trajectories | None = None,
        rejections: Rejections | None = None,
    ) -> None:
        scenario, count = choice.scenario, len(choice.scenario.vehicles)
        self.choice, self.settings, self.turn, self.rejections = choice, settings, 0, rejections
        self.checker = SceneChecker(scenario, limits)
        self.exits = Exits.of(scenario.map)
        self.motion = Trajectories.empty(samples, count, scenario.steps)
        self.spare = Trajectories.empty(samples, count, scenario.steps)
        self.badness = np.full((samples, count), np.inf)
        self.pending = np.ones((samples, count), np.bool_)
        self.goal = np.full((samples, count), NO_GOAL, np.int32)
        self.attempts = np.zeros((samples, count), np.int64)
        self.evictions = np.zeros((samples, count), np.int64)
        if target is not None:
            self.motion.put((slice(None), TARGET), target)
            self.pending[:, TARGET] = False
            self.evictions[:, TARGET] = settings.evictions
        self.target_steps = steps_to_avoid_target(scenario, settings.target_steps)
        self.draws = GoalDraws(choice, self.target_steps, samples, seed, exclusion=settings.exclusion, tempo=settings.tempo)

    def rows_to_plan(self, turn: int) -> NDArray[np.int64]:
        """Rows (sample, vehicle, candidate, attempt) that are to be planned in round `turn`."""
        self.turn = turn
        pending = np.argwhere(self.pending)
        if turn == 0:
            return np.column_stack([pending, self.draws.first[self.pending], np.zeros(len(pending), np.int64)])
        rows: list[tuple[int, int, int, int]] = []
        for k, n in pending.tolist():
            goals = self.draws.next_goals(k, n, self.motion[k], self.checker.size, self.settings.attempts)
            rows.extend((k, n, c, turn * MOST + a) for a, c in enumerate(goals))
        return np.array(rows, np.int64).reshape(-1, 4)

    def _others(self, n: int, samples: int | slice = slice(None)) -> Trajectories:
        """What is committed in `samples` (..., N, T) and vehicle n has to avoid."""
        motion = self.motion[samples]
        if self.target_steps[n] == motion.steps:
            return motion
        valid = motion.valid.copy()
        valid[..., TARGET, self.target_steps[n] :] = False
        return replace(motion, valid=valid)

    def commit(self, rows: NDArray[np.int64], motion: Trajectories) -> None:
        """Walk the pending vehicles in asset order, each in all samples at once; commit the first legal trajectory of each.

        Trajectories end where they leave the map, before they are judged.
        """
        motion = self.exits.leave(motion, self.checker.size[rows[:, 1], 0])
        alone = self.checker.alone(rows[:, 1], motion)
        for n in np.unique(rows[:, 1]).tolist():
            own = np.flatnonzero(rows[:, 1] == n)
            self._commit_vehicle(n, rows[own], motion[own], alone[own])
        if self.turn + 1 < self.settings.rounds:
            self._send_back()

    def _send_back(self) -> None:
        """Who does not give way to those that were committed after it is planned again, a bounded number of times."""
        takes = self.checker.takes_way(self.motion, self.settings.target_steps is not None)
        for k, n in np.argwhere(takes & ~self.pending & (self.evictions < self.settings.evictions)).tolist():
            self._turn_down(k, n, n, FLAGS[YIELD_GAP], self.motion.position[k, n])
            self._release(k, n)

    def _release(self, k: int, n: int) -> None:
        """Let what is committed be planned again; it is kept until there is something better."""
        self.evictions[k, n] += 1
        self.pending[k, n] = True
        self.spare.put((k, n), self.motion[k, n])
        self.badness[k, n] = 1.0  # of what is illegal nothing is as good: it is legal, or breaks one rule
        self.motion.valid[k, n] = False

    def _commit_vehicle(self, n: int, rows: NDArray[np.int64], motion: Trajectories, alone: Severities) -> None:
        """Judge what was planned for vehicle n, against what is committed before it in the same sample."""
        sample = rows[:, 0]
        severities = self.checker.among_samples(n, motion, sample, self._others(n), self.checker.size, alone)
        violation, first = severities.violation, severities.first_step
        starts = np.flatnonzero(np.diff(sample, prepend=-1)).tolist()
        for a, b in zip(starts, [*starts[1:], len(rows)], strict=True):
            self._judge(int(sample[a]), n, rows[a:b, 2], motion[a:b], violation[a:b], first[a:b])

    def _judge(
        self,
        k: int,
        n: int,
        candidate: NDArray[np.int64],
        motion: Trajectories,
        violation: NDArray[np.uint16],
        first: NDArray[np.int16],
    ) -> None:
        """Commit the first legal trajectory of vehicle n in sample k, or make way for one, or keep the least illegal."""
        first_legal, tried = self._first_legal(k, n, candidate, motion, violation)
        self.attempts[k, n] += tried
        for i in range(tried):
            if i != first_legal:
                self._turn_down(k, n, n, int(violation[i]), motion.position[i])
        if first_legal is not None:
            self._settle(k, n, int(candidate[first_legal]), motion[first_legal])
            return
        badness = badness_of(violation, first, motion.steps)
        chosen = int(badness.argmin())
        if badness[chosen] < self.badness[k, n]:
            self.badness[k, n], self.goal[k, n] = badness[chosen], candidate[chosen]
            self.spare.put((k, n), motion[chosen])

    def _turn_down(self, k: int, judged: int, n: int, violation: int, position: NDArray[np.float32]) -> None:
        """Note a trajectory (T, 2) of vehicle n in sample k that fell when vehicle `judged` was judged."""
        if self.rejections is not None:
            self.rejections.add((self.turn, k, judged), n, violation, position)

    def _first_legal(
        self, k: int, n: int, candidate: NDArray[np.int64], motion: Trajectories, violation: NDArray[np.uint16]
    ) -> tuple[int | None, int]:
        """Which trajectory to commit, None if no way was made for any, and how many were tried until it was found."""
        legal = np.flatnonzero(violation == 0)
        if len(legal):
            return int(legal[0]), int(legal[0]) + 1
        self.draws.fail(k, n, candidate)
        blocked = np.flatnonzero(violation == Violation.COLLISION)
        if len(blocked) and self._evict(k, n, motion[int(blocked[0])]):
            return int(blocked[0]), len(violation)
        return None, len(violation)

    def _settle(self, k: int, n: int, candidate: int, motion: Trajectories) -> None:
        self.pending[k, n], self.goal[k, n] = False, candidate
        self.motion.put((k, n), motion)

    def _evict(self, k: int, n: int, motion: Trajectories) -> bool:
        """Make way for a trajectory that only collides: whether all in its way could be sent to the next round."""
        if self.turn + 1 == self.settings.rounds:
            return False
        others = np.flatnonzero(self.checker.partners(n, motion, self._others(n, k)))
        if (self.evictions[k, others] >= self.settings.evictions).any() or len(others) == 0:
            return False
        for other in others.tolist():
            self._turn_down(k, n, other, Violation.COLLISION, self.motion.position[k, other])
            self._release(k, other)
        return True

    def result(self, method: str) -> Samples:
        """The samples as they stand: pending vehicles keep their least illegal trajectory or are dropped.

        Everything is judged once more together, so that a collision is charged to both partners; but for the target, where its
        driver has to react: of that the pending are judged by what they have to avoid.
        """
        left = self.pending
        owed, owed_first = self._owed(left if self.settings.target_steps is not None else np.zeros_like(left))
        if not self.settings.drop_illegal:
            for k, n in np.argwhere(left):
                self.motion.put((k, n), self.spare[k, n])
        violation, first = self.checker.check_samples(self.motion, self.settings.target_steps is not None)
        if not self.settings.drop_illegal:
            violation |= owed
            first = np.where((owed_first >= 0) & ((first < 0) | (owed_first < first)), owed_first, first)
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
            left_map=self.motion.valid[..., 0] & ~self.motion.valid[..., -1],
        )

    def _owed(self, left: NDArray[np.bool_]) -> tuple[NDArray[np.uint16], NDArray[np.int16]]:
        """What the least illegal trajectories of those that are `left` (K, N) break among the committed, the target for as long
        as each has to avoid it: flags and first steps (K, N).
        """
        violation, first = np.zeros(left.shape, np.uint16), np.full(left.shape, -1, np.int16)
        for n in np.flatnonzero(left.any(axis=0)).tolist():
            sample = np.flatnonzero(left[:, n])
            motion = self.spare[sample, n]
            alone = self.checker.alone(np.full(len(sample), n), motion)
            found = self.checker.among_samples(n, motion, sample, self._others(n), self.checker.size, alone)
            violation[sample, n], first[sample, n] = found.violation, found.first_step
        return violation, first

    def _probability(self, probabilities: Probabilities) -> NDArray[np.float32]:
        """(K, N) of the goals that are followed, NaN where none is."""
        columns = [p[self.goal[:, n]] for n, p in enumerate(probabilities)]
        return np.where(self.goal == NO_GOAL, np.nan, np.stack(columns, axis=1)).astype(np.float32)


def steps_to_avoid_target(scenario: Scenario, limit: int | None) -> NDArray[np.int64]:
    """(N,) steps for which each vehicle avoids the target: all of them if it heads the same way from behind it."""
    vehicles = scenario.vehicles
    if limit is None:
        return np.full(len(vehicles), scenario.steps)
    ahead = to_vehicle_frame(vehicles.position, vehicles.position[TARGET], vehicles.heading[TARGET])[:, 0]
    alike = np.abs(wrap_angle(vehicles.heading - vehicles.heading[TARGET])) < ALIKE
    return np.where((ahead <= 0) & alike, scenario.steps, limit)


def badness_of(violation: NDArray[np.uint16], first: NDArray[np.int16], steps: int) -> NDArray[np.float64]:
    """Fewer broken rules are better; among equals, the later the first one breaks the better."""
    rules = np.array([int(v).bit_count() for v in violation], np.float64)
    return rules + 1.0 - first / steps
