"""Who attacks where one vehicle is chosen beforehand: who comes nearest to the target as it drives."""

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Arena, social
from drivegen.core.scenario import Trajectories

BEHIND = 1e3
"""[m] that who comes up from behind counts as farther."""


def attackers(arena: Arena, scenes: NDArray[np.int64], driven: Trajectories) -> NDArray[np.int64]:
    """(V,) who comes nearest to the target in each of `scenes` (V,), -1 where nobody is there throughout."""
    found = np.full(len(scenes), -1, np.int64)
    for i, s in enumerate(scenes.tolist()):
        traffic = arena.ground.traffic[s]
        there = social(traffic)
        there = there[traffic.valid[there].all(1)]
        if len(there):
            near = approaches(arena.trials, driven, np.full(len(there), s), there, traffic[there])
            found[i] = there[np.argmin(near.gap + BEHIND * near.behind)]
    return found
