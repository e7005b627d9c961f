"""Traffic as it is: scenes are driven once each, as many as there are runs for, and nothing in them is exchanged."""

from drivegen.adversaries.shared.arena import Arena, share_out
from drivegen.adversaries.shared.settings import WithoutSettings
from drivegen.corner_cases.trials import Variants


class Unchanged(WithoutSettings):
    """See the module."""

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        arena.drive(Variants.unchanged(share_out(arena.ground.of, arena.left), arena.trials.steps))
