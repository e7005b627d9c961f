"""DriveGen with goals chosen by a vision-language model, the paper's own way; the tables' "DriveGen" has learned goals.

The model is asked by the stage goals@vlm, whose recorded odds are followed. Made without them it asks nobody: the learned
selector stands in, and `backend` says so.
"""

from drivegen.core.methods import Method
from drivegen.generators import drivegen

ABOUT = Method(
    title="DriveGen, goals by a vision-language model",
    line="DriveGen with goals that a vision-language model ranks by pictures: the paper as it is written.",
    kind="ours",
    goals="vlm",
    trains_on="the logs",
    places=False,
    additions=("exclusion", "checker", "tempo"),
)


class Plugin(drivegen.Plugin):
    """As DriveGen, with the odds that the selector `vlm` made of a model's ranking."""

    name = "drivegen_vlm"
    about = ABOUT
