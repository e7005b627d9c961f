"""For adversaries that have no settings."""

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class NoSettings:
    """There are none."""


class WithoutSettings:
    """What such an adversary begins with; see `base.Adversary`."""

    settings_type: ClassVar[type] = NoSettings

    def __init__(self, settings: NoSettings) -> None:
        del settings
