"""Whole episodes of a policy in the world: all rows begin together and end with their scenes, at a collision or a red light."""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from drivegen.drivers.shared.features import features
from drivegen.drivers.shared.network import pedals
from drivegen.world.observation import Action, runs_red
from drivegen.world.touch import touched
from drivegen.world.world import World

Choose = Callable[[int, Tensor, World], Tensor]
"""Step number, features (R, F) and the world -> numbers (R,)."""


@dataclass(frozen=True)
class Episodes:
    """R episodes of at most T steps.

    Attributes:
        features: (T + 1, R, F) what was seen before each step, and at the end. number: (T, R) what was done.
        live: (T, R) bool, whether the row had not ended. lasts: (R,) int64 steps of its scene. speed: (T + 1, R) [m/s].
        crashed, ran_red: (R,) bool, whether it ended at a collision, or by crossing a line at a red light.
    """

    features: Tensor
    number: Tensor
    live: Tensor
    lasts: Tensor
    speed: Tensor
    crashed: Tensor
    ran_red: Tensor

    @property
    def failed(self) -> Tensor:
        """(R,) bool, whether a fault ended it."""
        return self.crashed | self.ran_red

    @property
    def distance(self) -> Tensor:
        """(R,) [m] driven."""
        return (self.speed[1:] * self.live).sum(0) * 0.1


@torch.no_grad()
def play(world: World, chosen: Tensor, choose: Choose) -> Episodes:
    """Episodes of the world's rows in scenes `chosen` (R,)."""
    world.reset(chosen)
    look = world.observe()
    inputs, done, speed, touches, runs = [features(look)], [], [world.ego.speed], [_touches(world)], []
    for step in range(int(world.scenes.steps[chosen].max()) - 1):
        number, line, along = choose(step, inputs[-1], world), look.red_line, world.ego.along
        world.advance(Action(pedals(number.clamp(-1.0, 1.0))))
        look = world.observe()
        done.append(number)
        inputs.append(features(look))
        speed.append(world.ego.speed)
        touches.append(_touches(world))
        runs.append(runs_red(line, world.ego.along - along))
    collisions, reds = torch.stack(touches), torch.stack(runs)
    faults = torch.cat([collisions[:1], collisions[1:] | reds])
    before = faults.cumsum(0)[:-1] == 0  # no fault up to this step
    lasts = world.scenes.steps[chosen] - 1
    live = before & (torch.arange(len(done), device=chosen.device)[:, None] < lasts)
    crashed, ran = (collisions[1:] & live).any(0) | collisions[0], (reds & live).any(0)
    return Episodes(torch.stack(inputs), torch.stack(done), live, lasts, torch.stack(speed), crashed, ran)


def _touches(world: World) -> Tensor:
    return touched(world, world.neighbours.boxes(world)) >= 0
