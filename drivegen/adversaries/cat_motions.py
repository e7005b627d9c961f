"""CAT's choice among perturbed tracks instead of goals: what the choice is worth where nothing keeps to lanes.

Perturbed tracks have no natural odds, so overlap alone decides.
"""

from dataclasses import dataclass

from drivegen.adversaries import cat
from drivegen.adversaries.base import About
from drivegen.adversaries.shared.sources import Motions

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
    """`motions`: what is chosen from."""

    motions: Motions


class Plugin(cat.Chooser):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings, settings.motions)
