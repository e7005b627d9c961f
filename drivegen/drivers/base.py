"""The protocol of a driver: see S targets at once, answer with one action each.

A driver follows its target's path (the logged or generated route, extended along the lanes), so what it sees of
others is in the frame of that path, and what it decides is an acceleration and, where it can steer, an offset from the
path. The same driver works in every simulator.
"""

from typing import ClassVar, Protocol, runtime_checkable

from drivegen.world.observation import Action, Observation


class Driver(Protocol):
    """A driving algorithm; `Plugin(settings)` makes one.

    Attributes:
        name: the plugin's name, as it stands in tables.
        settings_type: the frozen dataclass of its settings.
    """

    name: str
    settings_type: ClassVar[type]

    def act(self, observation: Observation) -> Action:
        """Actions for S targets; row i depends on row i alone, so results do not depend on who shares the batch."""


@runtime_checkable
class RuleDriver(Protocol):
    """A driver that may look at `Observation.rules`; worlds look for them if it says so, which takes time."""

    @property
    def sees_rules(self) -> bool:
        """Whether it does."""


@runtime_checkable
class SumoDriver(Protocol):
    """A driver that SUMO itself can play."""

    @property
    def desired_speed(self) -> float:
        """Speed on roads without a limit [m/s]."""

    def vehicle_type(self) -> dict[str, str]:
        """Attributes of the SUMO vType that drives like this driver, `id` excepted."""
