"""DriveGen without goal selection: goals at random, the paper's ablation "DriveGen w/o gs"."""

from dataclasses import replace
from pathlib import Path

from drivegen.core.methods import Method
from drivegen.generators import drivegen
from drivegen.generators.base import Settings

ABOUT = Method(
    title="DriveGen w/o gs",
    line="DriveGen with goals drawn at random: the paper's ablation.",
    kind="ablation",
    goals="random",
    trains_on="the logs",
    places=False,
    additions=("exclusion", "checker", "tempo"),
)


class Plugin(drivegen.Plugin):
    """As DriveGen, with every candidate equally likely."""

    name = "drivegen_without_goals"
    about = ABOUT

    def __init__(self, models: Path, settings: Settings) -> None:
        """As DriveGen; no temperature, so that no manoeuvre gains by having many candidates."""
        super().__init__(models, replace(settings, temperature=1.0))
