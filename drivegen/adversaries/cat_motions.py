"""CAT's choice among perturbed tracks instead of goals: what the choice is worth where nothing keeps to lanes.

Perturbed tracks have no natural odds, so overlap alone decides.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries import cat
from drivegen.adversaries.base import About
from drivegen.adversaries.shared.arena import Arena
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.motions import Perturbation, exchanged_motions

ABOUT = About(
    title="CAT, motions",
    traffic="generated",
    varies="motions",
    source="Zhang and others, CAT, CoRL 2023",
    proposer="overlap, as CAT has it",
    stand_in="its choice by overlap among perturbed tracks, without odds, instead of DenseTNT's futures",
)


@dataclass(frozen=True)
class Settings(cat.Choosing):
    """`perturbation`: of the tracks that are chosen from."""

    perturbation: Perturbation


class Plugin(cat.Chooser):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self._perturbation = settings.perturbation

    def candidates(self, arena: Arena, scenes: NDArray[np.int64]) -> Candidates:
        """See `cat.Chooser`."""
        return exchanged_motions(arena, self._perturbation, self.settings.draws, scenes)
