"""One round of DriveGen-CS: generate with what is known, let the driver drive, learn from what happened.

Social vehicles stay under all rules between themselves and towards the map; only the target's reaction is left out of
the check, after a stated time to react. Each round is rehearsed: the driver drives through it once, then the others are
planned again around the target as it drove, so that nobody who follows it runs into its rear because it was slower than
planned. Nothing is trained.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.corner_cases.encounters import Encounters, encounters
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.pressure import PressureSettings, lean, risk
from drivegen.drivers.base import Driver
from drivegen.planners.base import Planner
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import Choices
from drivegen.rollout.scene import RolloutSettings
from drivegen.rollout.towards import plan_all_goals
from drivegen.simulators.base import Simulator
from drivegen.world.outcome import DrivingOutcome

METHOD = "drivegen_cs"

_OF_VEHICLES = ("violation", "first_violation", "goal", "natural", "used", "attempts", "dropped", "left_map")
"""What samples say of each vehicle (K, N), its motion apart."""


@dataclass(frozen=True)
class Drive:
    """A driver's run through K samples of one scenario.

    Attributes:
        samples: the traffic it met.
        target: Trajectories (K, T) of the driven target.
        outcome: DrivingOutcome of the K runs.
    """

    samples: Samples
    target: Trajectories
    outcome: DrivingOutcome

    @property
    def driven(self) -> Samples:
        """The samples with the target's row alone, as it was driven."""
        rows: dict[str, Any] = {name: getattr(self.samples, name)[:, :1] for name in _OF_VEHICLES}
        return replace(self.samples, motion=self.target[:, None], **rows | {"left_map": self.outcome.left_map[:, None]})


def lean_on(
    choices: Sequence[Choices],
    expected: Sequence[Trajectories],
    planner: Planner,
    knowledge: Knowledge,
    settings: PressureSettings,
    seed: int,
) -> list[Choices]:
    """Choices whose social vehicles' `used` probabilities favour encounters like past failures.

    `expected` holds per scenario the target's motion (K, T) in the round before; risks are averaged over its K samples.
    """
    planned = plan_all_goals(choices, planner, seed)
    return [_lean_one(*one, knowledge, settings) for one in zip(choices, expected, planned, strict=True)]


def _lean_one(
    choice: Choices, expected: Trajectories, planned: Trajectories, knowledge: Knowledge, settings: PressureSettings
) -> Choices:
    sizes = choice.scenario.vehicles.size
    owner = np.repeat(np.arange(len(sizes)), [len(c) for c in choice.candidates])
    met = encounters(expected, sizes[TARGET], planned[np.newaxis][np.zeros(len(expected.valid), np.intp)], sizes[owner])
    risks = risk(met, knowledge, settings).mean(axis=0)
    used = [odds if n == TARGET else lean(odds, risks[owner == n], settings) for n, odds in enumerate(choice.used)]
    return replace(choice, used=used)


def play(
    choices: Sequence[Choices],
    planner: Planner,
    limits: Limits,
    settings: RolloutSettings,
    driver: Driver,
    simulator: Simulator,
    samples: int,
    seed: int,
) -> list[Drive]:
    """Generate K = `samples` futures of every scenario and let the driver drive the target through each, after a rehearsal."""
    first = roll_out(choices, planner, limits, settings, samples, seed, METHOD)
    rehearsed = [_to_the_end(drive) for drive in _drive(choices, first, driver, simulator)]
    around = roll_out(choices, planner, limits, settings, samples, seed, METHOD, rehearsed)
    traffic = [_with_planned_target(futures, planned) for futures, planned in zip(around, first, strict=True)]
    return _drive(choices, traffic, driver, simulator)


def _drive(choices: Sequence[Choices], traffic: Sequence[Samples], driver: Driver, simulator: Simulator) -> list[Drive]:
    """Let the driver drive the target through every sample."""
    samples = len(traffic[0].dropped)
    scenarios = [choice.scenario for choice in choices for _ in range(samples)]
    outcome = simulator.run(driver, scenarios, [futures.motion[k] for futures in traffic for k in range(samples)])
    return [
        Drive(futures, outcome.motion[rows].until(choice.scenario.steps), outcome[rows])
        for choice, futures, rows in zip(choices, traffic, _blocks(len(choices), samples), strict=True)
    ]


def _to_the_end(drive: Drive) -> Trajectories:
    """The target's motion (K, T), standing where its run ended in a collision and gone where it left the map."""
    return drive.outcome.to_the_end.until(drive.target.steps)


def _with_planned_target(around: Samples, planned: Samples) -> Samples:
    """Traffic around the rehearsed target, with the target's own plan: it gives the path that the driver follows."""
    rows: dict[str, Any] = {name: _target_from(getattr(planned, name), getattr(around, name)) for name in _OF_VEHICLES}
    motion = around.motion.copy()
    motion.put((slice(None), TARGET), planned.motion[:, TARGET])
    return replace(around, motion=motion, **rows)


def _target_from(planned: NDArray[Any], around: NDArray[Any]) -> NDArray[Any]:
    """`around` (K, N, ...) with the target's row of `planned`."""
    out = around.copy()
    out[:, TARGET] = planned[:, TARGET]
    return out


def learn(knowledge: Knowledge, drives: Sequence[Drive], choices: Sequence[Choices], reach: float) -> Knowledge:
    """Knowledge with the encounters of all drives added."""
    for drive, choice in zip(drives, choices, strict=True):
        knowledge = knowledge.with_outcomes(encounters_of(drive, choice), taught(drive, choice), reach)
    return knowledge


def taught(drive: Drive, choice: Choices) -> NDArray[np.bool_]:
    """(K, N - 1), which runs ended in a collision with which social vehicle that knowledge is made of."""
    partner = drive.outcome.partner[:, None] == np.arange(1, len(choice.scenario.vehicles))
    return np.asarray(partner & drive.outcome.counted[:, None])


def encounters_of(drive: Drive, choice: Choices) -> Encounters:
    """Encounters (K, N - 1) of the driven target with each social vehicle."""
    sizes = choice.scenario.vehicles.size
    social = drive.samples.motion[:, 1:]
    return encounters(drive.target, sizes[TARGET], social, sizes[1:])


def _blocks(count: int, size: int) -> list[NDArray[np.intp]]:
    return list(np.arange(count * size).reshape(count, size))
