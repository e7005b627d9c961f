"""A driver's runs through many scenarios, and each scenario's means over them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.base import Driver
from drivegen.metrics.driving import run_numbers, spread_over_samples
from drivegen.simulators.base import Simulator
from drivegen.world.outcome import AT_FAULT, CollisionKind, DrivingOutcome, with_off_road


@dataclass(frozen=True)
class Drives:
    """Runs of one method's traffic.

    Attributes:
        scenarios: (C,) scenario ids. scene: (S,) the scenario of each run. outcome: DrivingOutcome of the S runs.
    """

    scenarios: list[str]
    scene: NDArray[np.int64]
    outcome: DrivingOutcome

    @classmethod
    def of(cls, simulator: Simulator, driver: Driver, traffic: Sequence[tuple[Scenario, Trajectories]]) -> Self:
        """Let `driver` drive through every pair of a scenario and traffic (N, T) in it; a scenario may come several times."""
        scenarios = [scenario for scenario, _ in traffic]
        ids = list(dict.fromkeys(scenario.scenario_id for scenario in scenarios))
        number = {name: i for i, name in enumerate(ids)}
        outcome = simulator.run(driver, scenarios, [motion for _, motion in traffic])
        scene = np.array([number[scenario.scenario_id] for scenario in scenarios], np.int64)
        return cls(ids, scene, with_off_road(outcome, scenarios))

    @classmethod
    def joined(cls, parts: "Sequence[Drives]") -> Self:
        """The runs of all parts, which share no scenario, in order; at least one."""
        before = np.cumsum([0, *(len(part.scenarios) for part in parts)])
        return cls(
            [name for part in parts for name in part.scenarios],
            np.concatenate([part.scene + first for part, first in zip(parts, before[:-1], strict=True)]),
            DrivingOutcome.joined([part.outcome for part in parts]),
        )

    def per_scenario(self) -> dict[str, NDArray[np.float64]]:
        """Means over each scenario's runs (C,) by metric: shares of collisions, `RunNumbers`, `spread_over_samples` [m].

        A run without a collision counts with an `impact_speed` of 0.
        """
        count = np.bincount(self.scene)
        means = {name: np.bincount(self.scene, value.astype(np.float64)) / count for name, value in self._per_run().items()}
        return means | {"spread_over_samples": spread_over_samples(self.outcome.motion, self.scene)}

    def _per_run(self) -> dict[str, NDArray[Any]]:
        outcome, numbers = self.outcome, run_numbers(self.outcome.motion)
        return {
            "collision": outcome.collided,
            "collision.at_fault": np.isin(outcome.kind, AT_FAULT),
            "collision.in_first_second": outcome.in_first_second,
            "collision.artefact": outcome.artefact,
            "collision.nuplan_at_fault": outcome.at_fault,
            "impact_speed": np.nan_to_num(outcome.impact_speed),
            "imposed_braking": outcome.imposed_braking,
            "imposed_loss": outcome.imposed_loss,
            **{f"collision.{kind.name.lower()}": outcome.kind == kind for kind in CollisionKind if kind},
            "left_map": outcome.left_map,
            "distance": numbers.distance,
            "absolute_acceleration": numbers.absolute_acceleration,
            "acceleration": numbers.acceleration,
            "hardest_braking": numbers.hardest_braking,
            "off_road": outcome.off_road,
        }
