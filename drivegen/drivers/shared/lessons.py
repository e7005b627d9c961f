"""What drivers learn from, how they are judged on the way, and the record of that."""

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
import torch
from torch import Tensor

from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories
from drivegen.drivers.shared.episodes import Choose, Episodes, play
from drivegen.drivers.shared.network import pedals
from drivegen.drivers.shared.policy import Policy, number_of
from drivegen.store.files import whole
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World


@dataclass(frozen=True)
class Lessons:
    """Scenes with logs and rules: `speed` (S, T) float32 [m/s] is what their targets were logged with, 0 after the end."""

    scenes: Scenes
    lookout: Lookout
    speed: Tensor

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], traffic: Sequence[Trajectories]) -> Self:
        """Scenarios with their motion (N, T), whose target shows how to drive."""
        scenes = Scenes.of(scenarios, traffic)
        speed = np.zeros((len(scenarios), scenes.longest), np.float32)
        for row, motion in enumerate(traffic):
            driven = np.hypot(*np.diff(motion.position[TARGET], axis=0).T) / DT
            seen = motion.valid[TARGET, 1:] & motion.valid[TARGET, :-1]
            speed[row, 1 : motion.steps] = np.where(seen, driven, 0.0)
        return cls(scenes, Lookout.of(scenes, scenarios, traffic), torch.from_numpy(speed))

    def __len__(self) -> int:
        return len(self.scenes)

    @torch.no_grad()
    def play(self, choose: Choose, chosen: Tensor | None = None) -> Episodes:
        """An episode in each scene, or in those `chosen` (R,)."""
        return play(self.scenes, self.lookout, torch.arange(len(self)) if chosen is None else chosen, choose)

    def demonstrations(self) -> Episodes:
        """The logged driving along the same paths, in the same world: nothing but the driving tells it from a policy's."""

        def pursue(step: int, _: Tensor, world: World) -> Tensor:
            return number_of((self.speed[:, step + 1] - world.ego.speed) / DT)

        return self.play(pursue)


@dataclass(frozen=True)
class Grade:
    """How a policy drives in validation scenes.

    Attributes:
        step: of the training. collision: share of episodes that end at one. distance: driven, relative to the logged.
        acceleration: mean of its absolute value [m/s2].
    """

    step: int
    collision: float
    distance: float
    acceleration: float

    @property
    def badness(self) -> float:
        """What the weights that are kept have least of: collisions, and how far the distance is off."""
        return self.collision + abs(self.distance - 1.0)


@runtime_checkable
class Taught(Protocol):
    """A driver that logs teach; `lessons_type()` is the dataclass that says how."""

    @classmethod
    def lessons_type(cls) -> type:
        """The type of the first argument of `teach`."""

    @classmethod
    def teach(
        cls, how: Any, train: Lessons, validation: Lessons, seed: int, say: Callable[[str], None]
    ) -> tuple[Policy, list[Grade]]:
        """The policy that drives best in `validation`, and how it drove there, first before it was taught.

        Same input, same bytes on one machine.
        """


def graded(step: int, policy: Policy, lessons: Lessons, logged: Episodes) -> Grade:
    """`logged` are the demonstrations of `lessons`."""
    run = lessons.play(lambda _, seen, __: policy(seen))
    effort = pedals(run.number.clamp(-1.0, 1.0)).abs()[run.live].mean()
    share = float(run.distance.mean() / logged.distance.mean())
    return Grade(step, float(run.crashed.float().mean()), share, float(effort))


def write_grades(path: Path, grades: Sequence[Grade]) -> None:
    """As CSV, a column an attribute."""
    lines = [",".join(f"{value:.6f}" if isinstance(value, float) else str(value) for value in astuple(one)) for one in grades]
    with whole(path) as temporary:
        temporary.write_text("\n".join([",".join(field.name for field in fields(Grade)), *lines]) + "\n")
