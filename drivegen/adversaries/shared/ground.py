"""Grounds to attack on: generated samples without whoever stayed illegal in them, logged traffic, or traffic generated now."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivegen.adversaries.shared.arena import Ground
from drivegen.adversaries.shared.legal import legal
from drivegen.checker.limits import Limits
from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Scenario
from drivegen.planners.base import Planner
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import Choices
from drivegen.rollout.scene import RolloutSettings


def sampled(choices: Sequence[Choices], samples: Sequence[Samples], scenes: int, planner: Planner, limits: Limits) -> Ground:
    """The first `scenes` samples of each scenario; who could not be made legal is left out, as in what is shipped.

    Raises UnusableInput where the samples are those of other scenarios.
    """
    if [choice.scenario.scenario_id for choice in choices] != [one.scenario_id for one in samples]:
        raise UnusableInput("the recorded traffic belongs to other scenarios: run the stage that made it again")
    traffic = [legal(one, k) for one in samples for k in range(min(scenes, len(one.dropped)))]
    of = np.repeat(np.arange(len(choices)), [min(scenes, len(one.dropped)) for one in samples])
    return Ground(choices, of, traffic, planner, limits)


def logged(choices: Sequence[Choices], planner: Planner, limits: Limits) -> Ground:
    """The scenarios that were recorded, as they were."""
    kept = [choice for choice in choices if choice.scenario.log is not None]
    return Ground(kept, np.arange(len(kept)), [c.scenario.log for c in kept if c.scenario.log is not None], planner, limits)


def generated(choices: Sequence[Choices], planner: Planner, limits: Limits, rollout: RolloutSettings, seed: int) -> Ground:
    """One scene of traffic for each, those apart in which nothing legal was found for the target."""
    futures = roll_out(choices, planner, limits, rollout, 1, seed, "drivegen") if choices else []
    kept = [n for n, future in enumerate(futures) if not future.dropped[0, TARGET]]
    return sampled([choices[n] for n in kept], [futures[n] for n in kept], 1, planner, limits)


def as_logs(ground: Ground) -> list[Scenario]:
    """Each of its scenes with its traffic as the log, and without whoever is not in it."""
    scenes = []
    for scenario, traffic in zip(ground.scenarios, ground.traffic, strict=True):
        there = np.flatnonzero(traffic.valid[:, 0])
        scenes.append(replace(scenario, vehicles=scenario.vehicles[there], log=traffic[there]))
    return scenes
