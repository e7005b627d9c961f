"""Whole episodes of a policy in the world: all rows begin together and end with their scenes or at a collision."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from drivegen.core.scenario import Trajectories
from drivegen.drivers.shared.features import features
from drivegen.drivers.shared.network import pedals
from drivegen.world.contact import first_overlaps
from drivegen.world.observation import Action
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World

Choose = Callable[[int, Tensor, World], Tensor]
"""Step number, features (R, F) and the world -> numbers (R,)."""


@dataclass(frozen=True)
class Episodes:
    """R episodes of at most T steps.

    Attributes:
        features: (T + 1, R, F) what was seen before each step, and at the end. number: (T, R) what was done.
        live: (T, R) bool, whether the row had not ended. crashed: (R,) bool, whether it ended at a collision.
        speed: (T + 1, R) [m/s].
    """

    features: Tensor
    number: Tensor
    live: Tensor
    crashed: Tensor
    speed: Tensor

    @property
    def distance(self) -> Tensor:
        """(R,) [m] driven."""
        return (self.speed[1:] * self.live).sum(0) * 0.1


def play(scenes: Scenes, lookout: Lookout, chosen: Tensor, choose: Choose) -> Episodes:
    """Episodes in scenes `chosen` (R,), whose rules are in `lookout`."""
    world = World(scenes, len(chosen), lookout=lookout)
    world.reset(chosen)
    seen, done, speed, poses = [features(world.observe())], [], [world.ego.speed], [_pose(world)]
    for step in range(int(scenes.steps[chosen].max()) - 1):
        number = choose(step, seen[-1], world)
        world.advance(Action(pedals(number.clamp(-1.0, 1.0))))
        done.append(number)
        seen.append(features(world.observe()))
        speed.append(world.ego.speed)
        poses.append(_pose(world))
    crash = _crashes(scenes, chosen, poses)
    steps = torch.arange(len(done), device=chosen.device)[:, None]
    ends = scenes.steps[chosen] - 1
    live = steps < torch.where(crash >= 0, torch.minimum(crash, ends), ends)
    return Episodes(torch.stack(seen), torch.stack(done), live, (crash >= 0) & (crash <= ends), torch.stack(speed))


def _pose(world: World) -> tuple[Tensor, Tensor]:
    return world.ego.position, world.ego.heading


def _crashes(scenes: Scenes, chosen: Tensor, poses: list[tuple[Tensor, Tensor]]) -> Tensor:
    """(R,) step of the first collision of each row, -1 without one."""
    position, heading = (torch.stack(part, 1).cpu().numpy() for part in zip(*poses, strict=True))
    others = scenes.replay.of(chosen.cpu().numpy())
    valid = np.arange(heading.shape[1]) < others.steps[:, None]
    motion = Trajectories(position, heading, np.zeros_like(position), valid)
    return torch.from_numpy(first_overlaps(motion, others)[0].astype(np.int64)).to(chosen.device)
