"""What an environment is like: how one acts, who is around, what is rewarded. Values stand in params.yaml, `environment`."""

from dataclasses import dataclass

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.world.reactive import Reaction

MOTIONS = {"path": 1, "path_offset": 2, "free": 2}
"""How one acts -> numbers of an action: see `environment.py`."""

Traffic = tuple[Scenario, Trajectories]
"""A scenario, and how everybody moves in it (N, T)."""

NEIGHBOURS = ("replayed", "reactive")


@dataclass(frozen=True)
class Rewards:
    """Weights of the terms of a step's reward; it is their sum.

    Attributes:
        progress: per metre along the path. comfort: of (a / 3 m/s2)^2. speeding: of how much faster than the limit [m/s] it is.
        collision: at a collision, but for
        hit: at one by somebody from behind, while standing, or with who appears inside the target.
        red: for crossing a line at a red light. off_road: for leaving the road, in `free` motion alone.
    """

    progress: float
    comfort: float
    speeding: float
    collision: float
    hit: float
    red: float
    off_road: float


@dataclass(frozen=True)
class Settings:
    """An environment.

    Attributes:
        motion: "path", "path_offset" or "free". neighbours: "replayed" or "reactive", by `reaction`.
        rules: whether signals and right of way are seen.
    """

    motion: str
    neighbours: str
    rules: bool
    reaction: Reaction
    rewards: Rewards

    def __post_init__(self) -> None:
        for name, value, choices in (("motion", self.motion, MOTIONS), ("neighbours", self.neighbours, NEIGHBOURS)):
            if value not in choices:
                raise UnusableInput(f"environment.{name} is one of {', '.join(choices)}, not {value!r}")
