"""DriveGen-CS's ranking among perturbed tracks instead of goals: what the ranking is worth where nothing keeps to lanes."""

from dataclasses import dataclass

from drivegen.adversaries import drivegen_cs
from drivegen.adversaries.base import About
from drivegen.adversaries.shared.sources import Motions

ABOUT = About(
    title="DriveGen-CS, motions",
    traffic="generated",
    varies="motions",
    source="Zhang and others, DriveGen (2025)",
    proposer="gap and warning, as DriveGen-CS has it",
)


@dataclass(frozen=True)
class Settings(drivegen_cs.Ranking):
    """`motions`: what is ranked."""

    motions: Motions


class Plugin(drivegen_cs.Ranked):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings, settings.motions)
