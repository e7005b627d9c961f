"""The batch simulator: thousands of scenarios advance together, a step is a few tensor operations.

The world of `drivegen.world`, driven to the end. Scenarios run in chunks of fixed shape, padded, on any torch device; on one
device a result does not depend on who shares the batch.
"""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.base import Driver
from drivegen.world.contact import outcome
from drivegen.world.outcome import DrivingOutcome
from drivegen.world.paths import TargetPaths, target_paths
from drivegen.world.replay import Replay
from drivegen.world.scenes import Scenes
from drivegen.world.world import World

CHUNK = 512
"""Scenarios that advance together."""


class Plugin:
    """Batched closed loop on a torch device."""

    name = "batch"

    def __init__(self, device: str = "cpu") -> None:
        self._device = torch.device(device)

    def run(
        self,
        driver: Driver,
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths | None = None,
    ) -> DrivingOutcome:
        """See `base.Simulator.run`."""
        torch.set_num_threads(1)  # sums depend on the thread count
        paths = paths if paths is not None else target_paths(scenarios, traffic)
        steps = max(motion.steps for motion in traffic)
        parts = []
        for begin in range(0, len(scenarios), CHUNK):
            rows = slice(begin, begin + CHUNK)
            parts.append(self._run_chunk(driver, scenarios[rows], traffic[rows], _rows(paths, rows), steps))
        return DrivingOutcome.joined(parts)

    def _run_chunk(
        self, driver: Driver, scenarios: Sequence[Scenario], traffic: Sequence[Trajectories], paths: TargetPaths, steps: int
    ) -> DrivingOutcome:
        scenes = Scenes.of(scenarios, traffic, paths, CHUNK, self._device)
        with torch.inference_mode():
            track = _drive(driver, World(scenes, CHUNK))
        return outcome(_trajectories(track, scenes.replay, steps), scenes.replay, scenarios)


def _drive(driver: Driver, world: World) -> tuple[Tensor, Tensor, Tensor]:
    """Position (T, S, 2), heading (T, S) and speed (T, S) of the targets."""
    poses = [world.ego]
    for _ in range(world.scenes.longest - 1):
        world.advance(driver.act(world.observe()))
        poses.append(world.ego)
    return (
        torch.stack([e.position for e in poses]),
        torch.stack([e.heading for e in poses]),
        torch.stack([e.speed for e in poses]),
    )


def _trajectories(track: tuple[Tensor, Tensor, Tensor], others: Replay, steps: int) -> Trajectories:
    """The targets' motion (S, steps), valid for as long as their scenarios last; step 0 is their logged pose."""
    position, heading, speed = (tensor.transpose(0, 1).cpu().numpy() for tensor in track)
    rows, done = speed.shape
    motion = Trajectories.empty(rows, steps)
    motion.position[:, :done], motion.heading[:, :done] = position, heading
    motion.position[:, 0], motion.heading[:, 0] = others.target_position, others.target_heading
    direction = np.stack([np.cos(motion.heading), np.sin(motion.heading)], axis=-1)
    motion.velocity[:, :done] = speed[..., None] * direction[:, :done]
    motion.valid[:] = np.arange(steps) < others.steps[:, None]
    return motion


def _rows(paths: TargetPaths, rows: slice) -> TargetPaths:
    return TargetPaths(paths.point[rows], paths.speed_limit[rows], paths.length[rows])
