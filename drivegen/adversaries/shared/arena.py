"""Where a driver is attacked: scenes with their traffic, who drives, what is allowed, and how often it may be driven."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.rules import RULES, Judge
from drivegen.checker.limits import Limits
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.trials import Trials, Variants
from drivegen.drivers.base import Driver
from drivegen.planners.base import Planner
from drivegen.roads.leaving import STAYS, Exits, left_from
from drivegen.rollout.choices import Choices
from drivegen.simulators.shared.drives import numbered
from drivegen.world.outcome import CollisionKind, DrivingOutcome


@dataclass(frozen=True)
class Ground:
    """C scenarios with S scenes of traffic, and what traffic is made with.

    Attributes:
        choices: (C,) scenarios with the goals of their vehicles. of: (S,) int64 the scenario of each scene, rising.
        traffic: (S,) motion (N, T); vehicles that are not there are left out of the scene.
        planner: fills in motion. limits: of the checker.
    """

    choices: Sequence[Choices]
    of: NDArray[np.int64]
    traffic: Sequence[Trajectories]
    planner: Planner
    limits: Limits

    @property
    def scenarios(self) -> list[Scenario]:
        """(S,)."""
        return [self.choices[c].scenario for c in self.of.tolist()]


@dataclass(frozen=True)
class Bounds:
    """What an adversary may do.

    Attributes:
        allowed: of RULES. budget: runs of the driver in each scenario.
        reaction_steps: others avoid the target's plan for so many steps: its driver's time to react.
    """

    allowed: str
    budget: int
    reaction_steps: int

    def __post_init__(self) -> None:
        if self.allowed not in RULES:
            raise UnusableInput(f"allowed is {' or '.join(RULES)}, not {self.allowed!r}: set it so where adversaries are told")


class Arena:
    """See the module.

    Attributes:
        ground, bounds, seed: see their classes. trials: runs of the driver. spent: (C,) int64 runs in each scenario.
        made: what was made here whoever drives, by what it was asked for with.
    """

    def __init__(self, driver: Driver, ground: Ground, bounds: Bounds, seed: int) -> None:
        if not len(ground.of):
            raise UnusableInput("there is no traffic to attack the driver in: give scenarios that have logs or futures")
        self.ground, self.bounds, self.seed = ground, bounds, seed
        self.trials = Trials(driver, ground.scenarios, ground.traffic)
        self.spent = np.zeros(len(ground.choices), np.int64)
        self._runs: list[tuple[Variants, NDArray[np.floating], NDArray[np.int64], DrivingOutcome]] = []
        self.made: dict[tuple[Any, ...], Any] = {}

    def again(self, driver: Driver) -> Self:
        """The same ground and bounds for another driver, no run made; what does not depend on who drives is shared."""
        _ = self.judges  # made once, and shared from here on
        other = copy(self)
        other.trials, other.spent, other._runs = self.trials.by(driver), np.zeros_like(self.spent), []
        return other

    @cached_property
    def judges(self) -> list[Judge]:
        """(S,)."""
        scenes = zip(self.ground.scenarios, self.ground.traffic, strict=True)
        return [Judge.of(scenario, motion, self.ground.limits, self.bounds.reaction_steps) for scenario, motion in scenes]

    @property
    def left(self) -> NDArray[np.int64]:
        """(C,) runs that are left in each scenario."""
        return self.bounds.budget - self.spent

    def share_of(self, rounds: int) -> NDArray[np.int64]:
        """(C,) runs of the next of `rounds` equal rounds in each scenario, rounded up."""
        return -(-self.left // rounds)

    def drive(self, variants: Variants, odds: NDArray[np.floating] | None = None) -> DrivingOutcome:
        """Drive through variants; `odds` (V,) are the natural odds of their attackers' goals.

        Raises AssertionError beyond the budget.
        """
        scenario = self.ground.of[variants.scene]
        query = self.spent[scenario] + numbered(scenario) + 1
        np.add.at(self.spent, scenario, 1)
        assert (self.left >= 0).all(), "an adversary drives more often than its budget allows"
        outcome = self.trials.run(variants)
        odds = np.full(len(variants), np.nan, np.float32) if odds is None else odds
        self._runs.append((variants, odds, query, outcome))
        return outcome

    def on_the_map(self, scene: NDArray[np.integer], vehicle: NDArray[np.integer], motion: Trajectories) -> Trajectories:
        """Tracks (E, T) of vehicles (E,) of scenes (E,), gone from where they leave the map, as all motion is."""
        step = np.full(len(scene), STAYS, np.int16)
        for s in np.unique(scene).tolist():
            mine, scenario = np.flatnonzero(scene == s), self.trials.scenarios[s]
            step[mine] = Exits.of(scenario.map).crossings(motion[mine], scenario.vehicles.size[vehicle[mine], 0])
        return left_from(motion, step)

    def allows(self, scene: NDArray[np.integer], vehicle: NDArray[np.integer], motion: Trajectories) -> NDArray[np.bool_]:
        """(E,) whether a track (E, T) of each vehicle (E,) may be exchanged in its scene (E,), the others staying as they are."""
        flags = np.zeros(len(scene), np.uint16)
        for s in np.unique(scene).tolist():
            mine = np.flatnonzero(scene == s)
            flags[mine] = self.judges[s].alone_and_among(vehicle[mine], motion[mine])
        return np.asarray((flags & RULES[self.bounds.allowed]) == 0)

    def first_allowed(
        self,
        scene: NDArray[np.integer],
        vehicle: NDArray[np.integer],
        motion: Trajectories,
        order: NDArray[np.integer],
        most: int | NDArray[np.integer],
    ) -> NDArray[np.int64]:
        """The first rows of `order` that may be driven, `most` in each scenario (C,) and no more than are left there.

        Tracks (E, T) are those that the arena `allows`; here everybody else is judged, too: who has to give way to them.
        """
        room, chosen = np.minimum(self.left, most), []
        for row in order.tolist():
            s = int(scene[row])
            c = int(self.ground.of[s])
            if room[c] > 0 and self.fits(s, vehicle[row : row + 1], motion[row : row + 1]):
                room[c] -= 1
                chosen.append(row)
        return np.array(chosen, np.int64)

    def fits(self, scene: int, vehicle: NDArray[np.integer], motion: Trajectories) -> bool:
        """Whether nobody else breaks a rule because of an exchanged track (1, T) of a vehicle (1,)."""
        if self.bounds.allowed != "legal":
            return True
        judge = self.judges[scene]
        return int(judge.whole([judge.exchanged(vehicle, motion)])[0]) == 0

    def runs(self) -> "Runs":
        """All runs so far, in the order in which they were driven; at least one."""
        variants, odds, query, outcome = zip(*self._runs, strict=True)
        return Runs(self, Variants.joined(variants), np.concatenate(odds), np.concatenate(query), DrivingOutcome.joined(outcome))

    def violation(self, scene: int, vehicle: NDArray[np.integer], motion: Trajectories) -> int:
        """Violation flags of a scene with exchanged tracks (E, T) of vehicles (E,); 0 is legal."""
        judge = self.judges[scene]
        changed = replace(judge, traffic=judge.exchanged(vehicle, motion))
        own = changed.alone_and_among(vehicle, motion)
        return int(np.bitwise_or.reduce(own, initial=0) | changed.whole([changed.traffic])[0])


@dataclass(frozen=True)
class Runs:
    """R runs of a driver in an arena.

    Attributes:
        variants: what was driven. odds: (R,) natural odds of the attackers' goals. query: (R,) number of the run in its scenario.
    """

    arena: Arena
    variants: Variants
    odds: NDArray[np.floating]
    query: NDArray[np.int64]
    outcome: DrivingOutcome

    @property
    def scenario(self) -> NDArray[np.int64]:
        """(R,) number of its scenario."""
        return self.arena.ground.of[self.variants.scene]

    def best(self, worth: NDArray[np.integer]) -> NDArray[np.int64]:
        """(C,) the run of most `worth` (R,) in each scenario, of equals the first, of worth 0 the last; -1 where is none."""
        order = np.lexsort((np.where(worth > 0, self.query, -self.query), -worth, self.scenario))
        scenario, first = np.unique(self.scenario[order], return_index=True)
        best = np.full(len(self.arena.ground.choices), -1, np.int64)
        best[scenario] = order[first]
        return best

    def case(self, run: int, driver: str, method: str) -> Case:
        """A run that ended in a collision."""
        scene, outcome = int(self.variants.scene[run]), self.outcome
        mine = np.flatnonzero(self.variants.row == run)
        vehicle, motion = self.variants.vehicle[mine], self.variants.motion[mine]
        traffic = self.arena.judges[scene].exchanged(vehicle, motion)
        return Case(
            scenario=self.arena.trials.scenarios[scene],
            traffic=traffic,
            attacker=int(self.variants.attacker[run]),
            driven=outcome.motion[run].until(traffic.steps),  # others of the arena may be longer
            step=int(outcome.step[run]),
            partner=int(outcome.partner[run]),
            kind=CollisionKind(int(outcome.kind[run])),
            at_fault=bool(outcome.at_fault[run]),
            impact_speed=float(outcome.impact_speed[run]),
            violation=self.arena.violation(scene, vehicle, motion),
            odds=float(self.odds[run]),
            queries=int(self.query[run]),
            driver=driver,
            method=method,
        )


def share_out(of: NDArray[np.int64], room: NDArray[np.integer]) -> NDArray[np.int64]:
    """Scenes, `room` (C,) of each scenario at most; `of` (S,) are the scenarios of all scenes."""
    return np.flatnonzero(numbered(of) < room[of]).astype(np.int64)


def everywhere(motion: Trajectories, scenes: NDArray[np.int64], count: int) -> Trajectories:
    """Motion (V, T) of `scenes` (V,) as that of all `count` scenes; nothing of those that were not driven."""
    whole = Trajectories.empty(count, motion.steps)
    whole.put(scenes, motion)
    return whole


def social(traffic: Trajectories) -> NDArray[np.int64]:
    """Vehicles of traffic (N, T) that may attack: those that are there, but for the target."""
    there = np.flatnonzero(traffic.valid[:, 0])
    return np.asarray(there[there != TARGET], np.int64)
