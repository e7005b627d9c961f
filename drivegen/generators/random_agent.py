"""Waymo's random agent: the anchor at the bottom of a realism score, no traffic at all.

Every position and heading of every step is drawn by itself, around a place one metre ahead and one to the left of the initial
pose, with a standard deviation of 0.1 (Montali et al. 2023, "The Waymo Open Sim Agents Challenge", baselines).
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drivegen.core.geometry import rotate, unit
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.core.seeds import rng

ABOUT = Method(
    title="Random agent",
    line="Every pose is drawn by itself around the first one (Montali et al. 2023).",
    kind="no traffic",
    goals=None,
    trains_on="nothing",
    places=False,
    additions=(),
)

MEAN, SPREAD = 1.0, 0.1
"""Of each coordinate [m] and of the heading [rad], relative to the initial pose."""


class Plugin:
    """Draws poses around the first one."""

    backend = "chance"
    about = ABOUT

    def __init__(self, models: Path, settings: object) -> None:
        """Needs neither models nor settings."""
        del models, settings

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K futures of each scenario, drawn by the seed and the scenario's id."""
        return [
            Samples.without_goals(s.scenario_id, "random_agent", _draw(s, samples, rng(seed, "random_agent", s.scenario_id)))
            for s in scenarios
        ]


def _draw(scenario: Scenario, samples: int, stream: np.random.Generator) -> Trajectories:
    """(K, N, T); the first step is the given one."""
    vehicles = scenario.vehicles
    shape = (samples, len(vehicles), scenario.steps)
    drawn = stream.normal(MEAN, SPREAD, (*shape, 3))
    drawn[:, :, 0] = 0
    start = vehicles.heading[:, None].astype(np.float64)
    position = vehicles.position[:, None] + rotate(drawn[..., :2], np.broadcast_to(start, shape))
    velocity = np.gradient(position, DT, axis=2)
    velocity[:, :, 0] = unit(vehicles.heading) * vehicles.speed[:, None]
    heading = (start + drawn[..., 2]).astype(np.float32)
    return Trajectories(position.astype(np.float32), heading, velocity.astype(np.float32), np.ones(shape, np.bool_))
