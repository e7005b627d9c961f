"""DriveGen without goal selection: goals at random, the paper's ablation "DriveGen w/o gs"."""

from drivegen.generators import drivegen


class Plugin(drivegen.Plugin):
    """As DriveGen, with every candidate equally likely."""

    name = "drivegen_without_goals"
    selector = "random"
