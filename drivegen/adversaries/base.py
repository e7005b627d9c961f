"""The protocol of an adversary: change traffic so that a driver collides, within a budget of runs of that driver.

`Plugin(settings)` makes one; `ABOUT = About(...)` in the same file says what it is, in literals.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from drivegen.adversaries.shared.arena import Arena

TRAFFIC = ("log", "generated")
VARIES = ("nothing", "goals", "motions")


@dataclass(frozen=True)
class About:
    """What an adversary is.

    Attributes:
        title: in tables. traffic: what it begins with, of TRAFFIC. varies: what it changes, of VARIES.
        source: the paper. proposer: how it chooses, in the same words as a file that chooses so from something else; "" for none.
        stand_in: what it stands in for, in words, where it is not the authors' own code; "" for our own.
    """

    title: str
    traffic: str
    varies: str
    source: str
    proposer: str = ""
    stand_in: str = ""


class Adversary(Protocol):
    """Attributes:
    settings_type: the frozen dataclass of its settings.
    """

    settings_type: ClassVar[type]

    def __init__(self, settings: Any) -> None:
        """See `settings_type`."""

    def attack(self, arena: Arena) -> None:
        """Spend the arena's budget: every run of the driver goes through `Arena.drive`, which keeps it.

        What it does in one scenario depends on that scenario, the seed and what the arena's other scenarios taught it.
        """
