"""DriveGen with goals chosen by a vision-language model, the paper's own way; the tables' "DriveGen" has learned goals.

The model is asked by the stage goals@vlm, whose recorded odds are followed. Made without them it asks nobody: the learned
selector stands in, and `backend` says so.
"""

from drivegen.generators import drivegen


class Plugin(drivegen.Plugin):
    """As DriveGen, with the odds that the selector `vlm` made of a model's ranking."""

    name = "drivegen_vlm"
    selector = "vlm"
