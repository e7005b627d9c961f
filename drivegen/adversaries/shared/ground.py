"""Grounds to attack on: generated samples without whoever stayed illegal in them, or logged traffic."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivegen.adversaries.shared.arena import Ground
from drivegen.checker.limits import Limits
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.planners.base import Planner
from drivegen.rollout.scene import Choices


def sampled(choices: Sequence[Choices], samples: Sequence[Samples], scenes: int, planner: Planner, limits: Limits) -> Ground:
    """The first `scenes` samples of each scenario; who could not be made legal is left out, as in what is shipped."""
    traffic = [legal(one, k) for one in samples for k in range(min(scenes, len(one.dropped)))]
    of = np.repeat(np.arange(len(choices)), [min(scenes, len(one.dropped)) for one in samples])
    return Ground(choices, of, traffic, planner, limits)


def logged(choices: Sequence[Choices], planner: Planner, limits: Limits) -> Ground:
    """The scenarios that were recorded, as they were."""
    kept = [choice for choice in choices if choice.scenario.log is not None]
    return Ground(kept, np.arange(len(kept)), [c.scenario.log for c in kept if c.scenario.log is not None], planner, limits)


def legal(samples: Samples, k: int) -> Trajectories:
    """Motion (N, T) of sample k, nobody in it but the target and those who are legal."""
    out = samples.violation[k] != 0
    out[TARGET] = False
    motion = samples.motion[k]
    return replace(motion, valid=motion.valid & ~out[:, None])
