"""A pool of draws of the natural law, many in each of many scenes, through which drivers are driven; neighbours react.

How near others come in a draw is known without a run of the driver in it: it is how near their planned motions come to where the
driver drove in the first draw of the scene, by the measure that ranks candidates of DriveGen-CS.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Ground
from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.scenario import DT, Trajectories
from drivegen.corner_cases.trials import Trials, Variants
from drivegen.drivers.base import Driver
from drivegen.exposure.law import NaturalLaw
from drivegen.exposure.rates import Trial, verified
from drivegen.rollout.choices import Choices
from drivegen.rollout.towards import plan_all_goals
from drivegen.simulators.batch import CHUNK
from drivegen.world.outcome import DrivingOutcome
from drivegen.world.reactive import Reaction

CAUTION, BEHIND = 0.2, 0.5
"""[m/s] the gap that a second of warning is worth, and [m] that of somebody who comes up from behind: numbers of its own."""


@dataclass(frozen=True)
class Drawn:
    """A scene with D draws of its law: `rows` (D, M) of the law's motion."""

    choice: Choices
    law: NaturalLaw
    rows: NDArray[np.int64]


def draw_scenes(ground: Ground, draws: int, tries: int, seed: int) -> Iterator[Drawn]:
    """Each scene of the ground with so many draws of its law, or with all that are legal among `tries` where these are fewer.

    The ground's traffic says who is there, and where the targets are told to drive. Draws depend on scene and seed alone.
    """
    planned = plan_all_goals(ground.choices, ground.planner, seeds.derive(seed, "natural law"))
    for c, traffic in zip(ground.of.tolist(), ground.traffic, strict=True):
        choice = ground.choices[c]
        law = NaturalLaw.of(choice, traffic, planned[c], ground.limits)
        yield Drawn(choice, law, law.draw(draws, tries, seeds.rng(seed, "natural law", choice.scenario.scenario_id)))


def with_enough(drawn: Iterable[Drawn], draws: int) -> tuple[list[Drawn], list[str]]:
    """The scenes that have so many draws, and the ids of the others."""
    scenes, left_out = list[Drawn](), list[str]()
    for one in drawn:
        if len(one.rows) == draws:
            scenes.append(one)
        else:
            left_out.append(one.choice.scenario.scenario_id)
    return scenes, left_out


class Pool:
    """N = S * D draws, numbered scene by scene.

    Attributes:
        scenes: (S,), at least one.
    """

    def __init__(self, scenes: Sequence[Drawn], driver: Driver, reaction: Reaction) -> None:
        """Traffic is packed for `driver`; others are driven as well."""
        self.scenes = scenes
        self._draws = len(scenes[0].rows)
        first = [scene.law.scenes(scene.rows[:1])[0] for scene in scenes]
        self._trials = Trials(driver, [scene.choice.scenario for scene in scenes], first, reaction)
        self._motion = [scene.law.motion.padded(self._trials.steps) for scene in scenes]

    def __len__(self) -> int:
        return len(self.scenes) * self._draws

    def drive(self, drivers: Sequence[Driver], picks: NDArray[np.integer]) -> list[DrivingOutcome]:
        """What becomes of each of several drivers in draws (R,) by number."""
        return self._trials.run_each(drivers, self._variants(picks))

    def failed(self, driver: Driver, picks: NDArray[np.integer]) -> NDArray[np.bool_]:
        """(R,) whether the driver has a counted collision in each of the draws."""
        some = np.array_split(picks, len(picks) // CHUNK + 1)  # traffic of thousands of draws at once takes gigabytes
        return np.concatenate([self.drive([driver], part)[0].counted for part in some])

    def first(self, driver: Driver) -> DrivingOutcome:
        """(S,) what becomes of a driver in the first draw of each scene."""
        return self.drive([driver], np.arange(len(self.scenes)) * self._draws)[0]

    def near(self, first: DrivingOutcome) -> NDArray[np.float32]:
        """(N,) [m] how near the others come in each draw to a driver, by its `first` runs (S,)."""
        owner = [np.repeat(scene.law.vehicle, np.diff(scene.law.start)) for scene in self.scenes]
        of = np.repeat(np.arange(len(self.scenes)), list(map(len, owner)))
        met = approaches(self._trials, first.to_the_end, of, np.concatenate(owner), Trajectories.joined(self._motion))
        cost = met.cost(CAUTION, BEHIND)
        ends = np.cumsum([0, *map(len, owner)])
        of_scenes = zip(self.scenes, pairwise(ends), strict=True)
        return np.concatenate([cost[low:high][scene.rows].min(axis=1, initial=np.inf) for scene, (low, high) in of_scenes])

    def _variants(self, picks: NDArray[np.integer]) -> Variants:
        nobody, none = np.zeros(len(picks), np.int64), np.zeros(0, np.int64)
        row, vehicle, motion = [none], [none], [Trajectories.empty(0, self._trials.steps)]
        for n, pick in enumerate(picks.tolist()):
            s, draw = divmod(pick, self._draws)
            row.append(np.full(len(self.scenes[s].law.vehicle), n))
            vehicle.append(self.scenes[s].law.vehicle)
            motion.append(self._motion[s][self.scenes[s].rows[draw]])
        of = (picks // self._draws).astype(np.int64)
        return Variants(of, nobody, np.concatenate(row), np.concatenate(vehicle), Trajectories.joined(motion))


def driven_seconds(outcome: DrivingOutcome) -> NDArray[np.float64]:
    """(R,) [s] how long each run lasts: until its target collides, leaves, or the end."""
    return np.asarray((outcome.motion.valid.sum(axis=1) - 1) * DT)


@dataclass(frozen=True)
class Exposure:
    """What became of M drivers in all D draws of S scenes.

    Attributes:
        scenarios: (S,) ids. seconds: (S,) how long the drivers drive there, in the mean of all runs.
        failed: (S, D, M) bool. near: (S, D, M) float32 [m].
        left_out: ids of further scenes in which too few draws were legal.
    """

    scenarios: list[str]
    seconds: list[float]
    failed: NDArray[np.bool_]
    near: NDArray[np.float32]
    left_out: list[str]

    @classmethod
    def of(cls, drawn: Iterable[Drawn], drivers: Sequence[Driver], draws: int, reaction: Reaction) -> "Exposure":
        """Drive everybody through everything; scenes may be none."""
        scenes, left_out = with_enough(drawn, draws)
        if not scenes:
            nothing = np.zeros((0, draws, len(drivers)))
            return cls([], [], nothing.astype(np.bool_), nothing.astype(np.float32), left_out)
        pool, count = Pool(scenes, drivers[0], reaction), len(scenes)
        parts = [pool.drive(drivers, np.arange(draws) + s * draws) for s in range(count)]
        failed = np.stack([np.stack([outcome.counted for outcome in part], axis=1) for part in parts])
        near = np.stack([pool.near(pool.first(driver)).reshape(count, draws) for driver in drivers], axis=2)
        seconds = [float(np.mean([driven_seconds(outcome) for outcome in part])) for part in parts]
        return cls([scene.choice.scenario.scenario_id for scene in scenes], seconds, failed, near, left_out)

    @classmethod
    def joined(cls, parts: "Sequence[Exposure]") -> "Exposure":
        """Scenes of all parts, of the same drivers, in order; at least one part."""
        return cls(
            [name for part in parts for name in part.scenarios],
            [length for part in parts for length in part.seconds],
            np.concatenate([part.failed for part in parts]),
            np.concatenate([part.near for part in parts]),
            [name for part in parts for name in part.left_out],
        )

    def rates(self, names: Sequence[str], trial: Trial, seed: int) -> dict[str, Any]:
        """The rates of the drivers (M,), and what intervals of them are worth (`verified`); all draws are taken for the law.

        `rate.low` and `rate.high` are over recordings. Raises UnusableInput where there is no scene.
        """
        if not self.scenarios:
            raise UnusableInput(f"too few draws were legal in all {len(self.left_out)} scenes: raise rates.tries")
        recordings, count = [recording(name) for name in self.scenarios], len(self.scenarios)
        ends = bootstrap_means(self.failed.mean(axis=1), recordings, trial.repetitions, seeds.rng(seed, "rates", "bootstrap"))
        rates = {}
        for m, name in enumerate(names):
            random = seeds.rng(seed, "rates", name)
            of_law = verified(self.failed[:, :, m], self.near[:, :, m], trial, count, random)
            rates[name] = {**of_law, "rate.low": ends[m].low, "rate.high": ends[m].high}
        about = {"scenes": count, "recordings": len(set(recordings)), "left_out": len(self.left_out)}
        about |= {"draws": self.failed.shape[1], "repetitions": trial.repetitions}
        return {**about, "seconds": float(np.mean(self.seconds)), "drivers": rates}
