"""DriveGen with the goals that the log reached: what is left to the planner and the checker. An upper bound, no method."""

from drivegen.generators import drivegen


class Plugin(drivegen.Plugin):
    """As DriveGen, told the true goal of every vehicle; looks at the log, and says so."""

    name = "drivegen_true_goals"
    selector = "log"
