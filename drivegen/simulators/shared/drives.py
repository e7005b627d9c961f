"""A driver's runs through many scenarios, and each scenario's means over them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.drivers.base import Driver
from drivegen.metrics.driving import run_numbers, spread_over_samples
from drivegen.simulators.base import Simulator
from drivegen.world.outcome import AT_FAULT, CollisionKind, DrivingOutcome, with_off_road
from drivegen.world.paths import TargetPaths


@dataclass(frozen=True)
class Drives:
    """Runs of one method's traffic.

    Attributes:
        scenarios: (C,) scenario ids. scene: (S,) the scenario of each run. outcome: DrivingOutcome of the S runs.
        planned: (S,) [m] the way that each target drives in its traffic, were it not for the driver.
    """

    scenarios: list[str]
    scene: NDArray[np.int64]
    outcome: DrivingOutcome
    planned: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        simulator: Simulator,
        driver: Driver,
        traffic: Sequence[tuple[Scenario, Trajectories]],
        paths: TargetPaths | None = None,
    ) -> Self:
        """Let `driver` drive through every pair of a scenario and traffic (N, T) in it; a scenario may come several times.

        `paths`: the `target_paths` of the pairs, where they were made already.
        """
        scenarios = [scenario for scenario, _ in traffic]
        ids = list(dict.fromkeys(scenario.scenario_id for scenario in scenarios))
        number = {name: i for i, name in enumerate(ids)}
        outcome = simulator.run(driver, scenarios, [motion for _, motion in traffic], paths)
        scene = np.array([number[scenario.scenario_id] for scenario in scenarios], np.int64)
        planned = [run_numbers(motion[TARGET : TARGET + 1]).distance[0] for _, motion in traffic]
        return cls(ids, scene, with_off_road(outcome, scenarios), np.array(planned))

    @classmethod
    def joined(cls, parts: "Sequence[Drives]") -> Self:
        """The runs of all parts, which share no scenario, in order; at least one."""
        before = np.cumsum([0, *(len(part.scenarios) for part in parts)])
        return cls(
            [name for part in parts for name in part.scenarios],
            np.concatenate([part.scene + first for part, first in zip(parts, before[:-1], strict=True)]),
            DrivingOutcome.joined([part.outcome for part in parts]),
            np.concatenate([part.planned for part in parts]),
        )

    def per_scenario(self) -> dict[str, NDArray[np.float64]]:
        """Means over each scenario's runs (C,) by metric: shares of collisions, `RunNumbers`, `spread_over_samples` [m].

        A run without a collision counts with an `impact_speed` of 0; what a run of one step has no number for is of the others.
        """
        values = self._numbers() | kind_shares(self.outcome)
        means = {name: self._mean(value.astype(np.float64)) for name, value in values.items()}
        return means | {"spread_over_samples": spread_over_samples(self.outcome.motion, self.scene)}

    def _mean(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """(C,) of each scenario's runs (S,) that have a number; NaN where none has."""
        known, count = np.isfinite(value), len(self.scenarios)
        runs = np.bincount(self.scene[known], minlength=count)
        total = np.bincount(self.scene[known], value[known], minlength=count)
        return np.asarray(np.divide(total, runs, out=np.full(count, np.nan), where=runs > 0))

    def per_run(self) -> tuple[list[str], NDArray[np.int64], dict[str, NDArray[np.float64]]]:
        """The scenario of each run (S,), its number there, and what the means are of, by metric; and `impacts`."""
        return [self.scenarios[s] for s in self.scene], numbered(self.scene), self._numbers() | impacts(self.outcome)

    def as_samples(self, driver: str) -> list[Samples]:
        """Each run as a sample of the target alone, a collision as its violation; of runs of one sample a scenario."""
        out = []
        for row, scene in enumerate(self.scene.tolist()):
            one = Samples.without_goals(self.scenarios[scene], driver, self.outcome.motion[row][np.newaxis, np.newaxis])
            if self.outcome.collided[row]:
                one.violation[:], one.first_violation[:] = Violation.COLLISION, self.outcome.step[row]
            out.append(one)
        return out

    def _numbers(self) -> dict[str, NDArray[Any]]:
        outcome = self.outcome
        return run_metrics(outcome) | {
            "collision.artefact": outcome.artefact,
            "collision.nuplan_at_fault": outcome.at_fault,
            "impact_speed": np.nan_to_num(outcome.impact_speed),
            "imposed_braking": outcome.imposed_braking,
            "imposed_loss": outcome.imposed_loss,
            "hardest_braking": run_numbers(outcome.motion).hardest_braking,
            "off_road": outcome.off_road,
            "red_lights": outcome.red_lights,
            "red_run": outcome.red_run,
            "planned_distance": self.planned,
        }


def numbered(scene: NDArray[np.integer]) -> NDArray[np.int64]:
    """Each run's number among those of its scene, (S,) of the scene of each (S,): the sample that it drove through."""
    order = np.argsort(scene, kind="stable")
    number = np.empty(len(scene), np.int64)
    number[order] = np.arange(len(scene)) - np.searchsorted(scene[order], scene[order])
    return number


def run_metrics(outcome: DrivingOutcome) -> dict[str, NDArray[Any]]:
    """What is said of each of S runs, (S,) by metric: how it ended, then `RunNumbers`."""
    numbers = run_numbers(outcome.motion)
    return {
        "collision": outcome.collided,
        "collision.at_fault": np.isin(outcome.kind, AT_FAULT),
        "collision.in_first_second": outcome.in_first_second,
        "left_map": outcome.left_map,
        "distance": numbers.distance,
        "absolute_acceleration": numbers.absolute_acceleration,
        "acceleration": numbers.acceleration,
    }


def kind_shares(outcome: DrivingOutcome) -> dict[str, NDArray[np.bool_]]:
    """Whether each of S runs ended in a collision of that kind, (S,) by metric."""
    return {f"collision.{kind.name.lower()}": outcome.kind == kind for kind in CollisionKind if kind}


def impacts(outcome: DrivingOutcome) -> dict[str, NDArray[np.float64]]:
    """Of those of S runs that ended in a collision: its step, the partner, and a 1 under its kind; (S,) by metric, else NaN."""
    kinds = {f"impact.kind.{kind.name.lower()}": np.where(outcome.kind == kind, 1.0, np.nan) for kind in CollisionKind if kind}
    places: dict[str, NDArray[Any]] = {"impact.step": outcome.step, "impact.partner": outcome.partner}
    return kinds | {name: np.where(outcome.collided, value, np.nan) for name, value in places.items()}
