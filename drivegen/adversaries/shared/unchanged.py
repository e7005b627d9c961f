"""Traffic as it is: every scene is driven once, and nothing in it is exchanged."""

import numpy as np

from drivegen.adversaries.shared.arena import Arena
from drivegen.adversaries.shared.settings import WithoutSettings
from drivegen.corner_cases.trials import Variants


class Unchanged(WithoutSettings):
    """See the module."""

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        arena.drive(Variants.unchanged(np.arange(len(arena.ground.of)), arena.trials.steps))
