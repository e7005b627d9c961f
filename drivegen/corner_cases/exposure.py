"""What drivers meet in traffic that follows the natural law: many draws for every scene, and who fails in each of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.scenario import DT, Trajectories
from drivegen.core.seeds import rng
from drivegen.corner_cases.rates import Trial, verified
from drivegen.corner_cases.trials import Trials, Variants
from drivegen.drivers.base import Driver
from drivegen.planners.base import Planner
from drivegen.rollout.batch import plan_all_goals
from drivegen.rollout.natural import NaturalLaw
from drivegen.rollout.scene import Choices
from drivegen.world.reactive import Reaction


@dataclass(frozen=True)
class Exposure:
    """D draws of the law in S scenes, as many in each.

    Attributes:
        drivers: (M,) names. scenarios: (S,) ids. seconds: (S,) how long they last.
        failed: (S, D, M) bool, whether each driver had a counted collision.
        left_out: ids of further scenes in which too few draws were legal.
    """

    drivers: list[str]
    scenarios: list[str]
    seconds: list[float]
    failed: NDArray[np.bool_]
    left_out: list[str]

    @classmethod
    def joined(cls, parts: "Sequence[Exposure]") -> "Exposure":
        """Scenes of all parts, of the same drivers, in order; at least one."""
        return cls(
            parts[0].drivers,
            [name for part in parts for name in part.scenarios],
            [length for part in parts for length in part.seconds],
            np.concatenate([part.failed for part in parts]),
            [name for part in parts for name in part.left_out],
        )

    def rates(self, tested: Sequence[str], house: Sequence[str], trial: Trial, seed: int) -> dict[str, Any]:
        """The rate of each tested driver, and what intervals of it are worth (`verified`); the draws are taken for the law.

        Nobody of its house is made of the same sound driver. `rate.low` and `rate.high` are over recordings. Where no scene is
        left, UnusableInput is raised.
        """
        if not self.scenarios:
            raise UnusableInput(f"too few draws were legal in all {len(self.left_out)} scenes: raise rates.tries")
        recordings = [recording(name) for name in self.scenarios]
        columns = [self.drivers.index(name) for name in tested]
        random = rng(seed, "rates", "bootstrap")
        ends = bootstrap_means(self.failed[:, :, columns].mean(axis=1), recordings, trial.repetitions, random)
        failed, rates = self.failed.reshape(-1, len(self.drivers)), {}
        for name, own, interval in zip(tested, columns, ends, strict=True):
            others = [self.drivers.index(other) for other in apart(house, name)]
            of_law = verified(failed[:, own], failed[:, others], trial, rng(seed, "rates", name))
            rates[name] = {**of_law, "rate.low": interval.low, "rate.high": interval.high}
        about = {"scenes": len(self.scenarios), "recordings": len(set(recordings)), "left_out": len(self.left_out)}
        about |= {"draws": self.failed.shape[1], "repetitions": trial.repetitions}
        return {**about, "seconds": float(np.mean(self.seconds)), "drivers": rates}


def apart(house: Sequence[str], tested: str) -> list[str]:
    """Those of the house that are not made of the same sound driver as `tested`, which may itself be mutated."""
    return [name for name in house if name.partition(".")[0] != tested.partition(".")[0]]


def expose(
    choices: Sequence[Choices],
    traffic: Sequence[Trajectories],
    planner: Planner,
    limits: Limits,
    drivers: Mapping[str, Driver],
    draws: int,
    most: int,
    reaction: Reaction,
    seed: int,
) -> Exposure:
    """Drive M `drivers` through `draws` of the law of each scene, whose neighbours react.

    `traffic` (S,) says who is there, and where the targets are told to drive. A scene in which `most` draws hold too few legal
    ones is left out.
    """
    scenarios, seconds, left_out = list[str](), list[float](), list[str]()
    failed = [np.zeros((0, draws, len(drivers)), np.bool_)]
    planned = plan_all_goals(choices, planner, seeds.derive(seed, "natural law"))
    for choice, motion, towards in zip(choices, traffic, planned, strict=True):
        name = choice.scenario.scenario_id
        law = NaturalLaw.of(choice, motion, towards, limits)
        rows = law.draw(draws, most, rng(seed, "natural law", name))
        if len(rows) < draws:
            left_out.append(name)
            continue
        scenarios.append(name)
        seconds.append((choice.scenario.steps - 1) * DT)
        failed.append(_failed(choice, law, rows, list(drivers.values()), reaction)[np.newaxis])
    return Exposure(list(drivers), scenarios, seconds, np.concatenate(failed), left_out)


def _failed(
    choice: Choices, law: NaturalLaw, rows: NDArray[np.int64], drivers: Sequence[Driver], reaction: Reaction
) -> NDArray[np.bool_]:
    """(D, M)."""
    trials = Trials(drivers[0], [choice.scenario], [law.scenes(rows[:1])[0]], reaction)
    count, nobody = len(rows), np.zeros(len(rows), np.int64)
    everybody = np.tile(law.vehicle, count)
    variants = Variants(nobody, nobody, np.repeat(np.arange(count), len(law.vehicle)), everybody, law.motion[rows.ravel()])
    return np.stack([outcome.counted for outcome in trials.run_each(drivers, variants)], axis=1)
