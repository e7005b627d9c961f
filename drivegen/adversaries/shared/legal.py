"""What attacks see of a generated sample."""

from dataclasses import replace

from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Trajectories


def legal(samples: Samples, k: int) -> Trajectories:
    """Motion (N, T) of sample k, nobody in it but the target and those who are legal."""
    out = samples.violation[k] != 0
    out[TARGET] = False
    motion = samples.motion[k]
    return replace(motion, valid=motion.valid & ~out[:, None])
