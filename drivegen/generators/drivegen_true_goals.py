"""DriveGen with the goals that the log reached: what is left to the planner and the checker. An upper bound, no method."""

from drivegen.core.methods import Method
from drivegen.generators import drivegen

ABOUT = Method(
    title="DriveGen, true goals",
    line="DriveGen told the true goal of every vehicle: what is left to planner and checker.",
    kind="bound",
    goals="log",
    trains_on="the logs",
    places=False,
    additions=("exclusion", "checker", "tempo"),
)


class Plugin(drivegen.Plugin):
    """As DriveGen, told the true goal of every vehicle; looks at the log, and says so."""

    name = "drivegen_true_goals"
    about = ABOUT
