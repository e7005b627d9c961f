"""DriveGen's two models and nothing else: each vehicle draws its own goal and is planned once, legal or not."""

from dataclasses import replace
from pathlib import Path

from drivegen.core.methods import Method
from drivegen.generators import drivegen
from drivegen.generators.base import Settings

ABOUT = Method(
    title="DriveGen, models alone",
    line="DriveGen without its additions: no exclusion among goals, no checker, no shared tempo.",
    kind="ablation",
    goals="learned",
    trains_on="the logs",
    places=False,
    additions=(),
)


class Plugin(drivegen.Plugin):
    """As DriveGen, without its additions."""

    name = "drivegen_alone"
    about = ABOUT

    def __init__(self, models: Path, settings: Settings) -> None:
        """As DriveGen."""
        alone = replace(settings.rollout, rounds=1, evictions=0, exclusion=False, tempo=0.0)
        super().__init__(models, replace(settings, rollout=alone))
