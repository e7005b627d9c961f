"""Random motions: one vehicle's track gets other accelerations and curvatures, all alike, as if nothing were known.

A scenario in which none is allowed is driven as it is, once.
"""

import numpy as np

from drivegen.adversaries.base import About
from drivegen.adversaries.random import drive_at_random
from drivegen.adversaries.shared.arena import Arena
from drivegen.adversaries.shared.motions import Perturbation, exchanged_motions

ABOUT = About(title="random motions", traffic="generated", varies="motions", source="none", proposer="chance")


class Plugin:
    """See the module."""

    settings_type = Perturbation

    def __init__(self, settings: Perturbation) -> None:
        self.settings = settings

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        drive_at_random(exchanged_motions(arena, self.settings, 1, np.arange(len(arena.ground.of))), arena)
