"""What drivers learn from, how they are judged on the way, and the record of that."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields, replace
from pathlib import Path
from typing import Self

import numpy as np
import torch
from torch import Tensor

from drivegen.core.scenario import DT, TARGET
from drivegen.drivers.shared.conditions import Traffic
from drivegen.drivers.shared.episodes import Choose, Episodes, play
from drivegen.drivers.shared.policy import Policy, number_of
from drivegen.store.files import whole
from drivegen.world.reactive import Reaction, Reactive
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World


@dataclass(frozen=True)
class Lessons:
    """Scenarios with `traffic` whose targets show how to drive.

    Attributes:
        scenes: all of it, packed. lookout: its rules. speed: (S, T) float32 [m/s] of the targets, in a gap what it was before.
        last: (S,) int64 the step at which each target is there for the last time.
    """

    traffic: Sequence[Traffic]
    scenes: Scenes
    lookout: Lookout
    speed: Tensor
    last: Tensor

    @classmethod
    def of(cls, traffic: Sequence[Traffic]) -> Self:
        """Pairs of a scenario and motion (N, T) in it."""
        scenarios, motions = [s for s, _ in traffic], [m for _, m in traffic]
        scenes = Scenes.of(scenarios, motions)
        speed = np.zeros((len(traffic), scenes.longest), np.float32)
        for row, motion in enumerate(motions):
            driven = np.hypot(*np.diff(motion.position[TARGET], axis=0).T) / DT
            driving = motion.valid[TARGET, 1:] & motion.valid[TARGET, :-1]
            latest = np.maximum.accumulate(np.where(driving, np.arange(len(driving)), -1))
            speed[row, 1 : motion.steps] = np.where(latest >= 0, driven[latest], 0.0)
        last = torch.from_numpy(np.array([motion.last_valid()[TARGET] for motion in motions], np.int64))
        return cls(traffic, scenes, Lookout.of(scenes, scenarios, motions), torch.from_numpy(speed), last)

    def __len__(self) -> int:
        return len(self.scenes)

    def world(self, rows: int, reaction: Reaction | None) -> World:
        """Rows among neighbours that react, or, where `reaction` is None, are replayed."""
        neighbours = Reactive(self.scenes, rows, reaction) if reaction else None
        return World(self.scenes, rows, neighbours, self.lookout)

    def play(self, choose: Choose) -> Episodes:
        """An episode in each scene among replayed neighbours."""
        return play(self.world(len(self), None), torch.arange(len(self)), choose)

    def demonstrations(self) -> Episodes:
        """The targets' own driving along the same paths, in the same world: nothing but the driving tells it from a policy's.

        It ends where a target is there for the last time.
        """

        def pursue(step: int, _: Tensor, world: World) -> Tensor:
            return number_of((self.speed[:, step + 1] - world.ego.speed) / DT)

        run = self.play(pursue)
        there = torch.arange(len(run.live))[:, None] < self.last
        lasted = run.live.sum(0) <= self.last  # what ended it later is not the target's doing
        return replace(run, live=run.live & there, crashed=run.crashed & lasted, ran_red=run.ran_red & lasted)


USUAL = (0.95, 1.15)
"""A way between these, relative to the logged one, is as good as any other."""


@dataclass(frozen=True)
class Grade:
    """How a policy drives in validation scenes, among replayed neighbours.

    Attributes:
        round: of the training. collision: share of episodes that end at one. red: share of those that run a red light.
        distance: driven, relative to the logged. acceleration: mean of its absolute value [m/s2].
    """

    round: int
    collision: float
    red: float
    distance: float
    acceleration: float

    @property
    def badness(self) -> float:
        """What the weights that are kept have least of: collisions, red lights run, and how far the distance is beyond USUAL."""
        return self.collision + self.red + max(USUAL[0] - self.distance, self.distance - USUAL[1], 0.0)


def graded(number: int, policy: Policy, lessons: Lessons, logged: Episodes) -> Grade:
    """`logged` are the demonstrations of `lessons`."""
    run = lessons.play(lambda _, features, __: policy(features))
    effort = run.speed.diff(dim=0).abs()[run.live].mean() / DT
    collision, red = (float(ended.float().mean()) for ended in (run.crashed, run.ran_red))
    return Grade(number, collision, red, float(run.distance.mean() / logged.distance.mean()), float(effort))


def write_grades(path: Path, grades: Sequence[Grade]) -> None:
    """As CSV, a column an attribute."""
    lines = [",".join(f"{value:.6f}" if isinstance(value, float) else str(value) for value in astuple(one)) for one in grades]
    with whole(path) as temporary:
        temporary.write_text("\n".join([",".join(field.name for field in fields(Grade)), *lines]) + "\n")
