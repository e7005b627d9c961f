"""DriveGen-CS's ranking among perturbed tracks instead of goals: what the ranking is worth where nothing keeps to lanes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries import drivegen_cs
from drivegen.adversaries.base import About
from drivegen.adversaries.shared.arena import Arena
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.motions import Perturbation, exchanged_motions

ABOUT = About(
    title="DriveGen-CS, motions",
    traffic="generated",
    varies="motions",
    source="Zhang and others, DriveGen (2025)",
    proposer="gap and warning, as DriveGen-CS has it",
)


@dataclass(frozen=True)
class Settings(drivegen_cs.Ranking):
    """`perturbation`: of the tracks that are ranked."""

    perturbation: Perturbation


class Plugin(drivegen_cs.Ranked):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self._perturbation = settings.perturbation

    def candidates(self, arena: Arena, scenes: NDArray[np.int64]) -> Candidates:
        """See `drivegen_cs.Ranked`."""
        return exchanged_motions(arena, self._perturbation, self.settings.draws, scenes)
