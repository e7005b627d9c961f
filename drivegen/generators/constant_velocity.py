"""Every vehicle keeps its initial speed and heading: the floor that any learned generator has to beat."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drivegen.core.geometry import unit
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, Scenario, Trajectories

ABOUT = Method(
    title="Constant velocity",
    line="Every vehicle keeps its speed and heading.",
    kind="rules",
    goals=None,
    trains_on="nothing",
    places=False,
    additions=(),
)


def constant_velocity(scenario: Scenario) -> Trajectories:
    """The straight continuation (N, T) of each vehicle's initial state."""
    vehicles, steps = scenario.vehicles, scenario.steps
    velocity = (unit(vehicles.heading) * vehicles.speed[:, None]).astype(np.float32)
    time = np.arange(steps, dtype=np.float32) * np.float32(DT)
    count = len(vehicles)
    return Trajectories(
        position=vehicles.position[:, None] + velocity[:, None] * time[:, None],
        heading=np.repeat(vehicles.heading[:, None], steps, axis=1),
        velocity=np.repeat(velocity[:, None], steps, axis=1),
        valid=np.ones((count, steps), np.bool_),
    )


class Plugin:
    """Constant velocity; all K samples are the same."""

    backend = "none"
    about = ABOUT

    def __init__(self, models: Path, settings: object) -> None:
        """Needs neither models nor settings."""
        del models, settings

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K copies of the straight continuation of each scenario."""
        del seed
        repeat = np.zeros(samples, np.intp)
        return [
            Samples.without_goals(s.scenario_id, "constant_velocity", constant_velocity(s)[np.newaxis][repeat]) for s in scenarios
        ]
