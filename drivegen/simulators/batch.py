"""The batch simulator: thousands of scenarios advance together, a step is a few tensor operations.

The target keeps to its path: with acceleration a its speed becomes max(0, v + a dt) and it moves on by that (the Euler step
that SUMO takes, too); an offset that the driver asks for is approached at most at STEEPEST to the path. Scenarios run in
chunks of fixed shape, padded, on any torch device; on one device a result does not depend on who shares the batch.
"""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.drivers.base import Driver, Observation, Paths
from drivegen.simulators.base import DrivingOutcome, TargetPaths
from drivegen.simulators.shared.contact import outcome
from drivegen.simulators.shared.paths import target_paths
from drivegen.simulators.shared.replay import Replay, replay

CHUNK = 512
"""Scenarios that advance together."""

STEEPEST = 0.3
"""Largest slope towards a wanted offset [m across per m along]."""


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
        others = replay(scenarios, traffic, paths, CHUNK)
        with torch.inference_mode():
            track = _drive(driver, others, _padded(paths, CHUNK), self._device)
        return outcome(_trajectories(track, others, steps), others, scenarios)


def _drive(driver: Driver, others: Replay, paths: Paths, device: torch.device) -> tuple[Tensor, Tensor, Tensor]:
    """Position (T, S, 2), heading (T, S) and speed (T, S) of the targets."""
    paths = Paths(*(tensor.to(device) for tensor in (paths.point, paths.heading, paths.speed_limit, paths.length)))
    frame = torch.from_numpy(others.frame).to(device)
    present = torch.from_numpy(np.ascontiguousarray(others.valid.transpose(2, 0, 1))).to(device)
    size = torch.from_numpy(others.target_size).to(device)
    speed = torch.from_numpy(others.target_speed).to(device)
    along, offset, slope = torch.zeros_like(speed), torch.zeros_like(speed), torch.zeros_like(speed)
    poses = []
    for t in range(present.shape[0]):
        row = paths.row(along[:, None])
        heading = paths.heading.gather(1, row)[:, 0]
        leftward = torch.stack([-heading.sin(), heading.cos()], -1)
        poses.append((paths.position(along[:, None])[:, 0] + offset[:, None] * leftward, heading + slope.atan(), speed))
        action = driver.act(_observed(t, (along, offset, speed), size, frame[:, t], present[t], paths))
        speed = (speed + action.acceleration * DT).clamp_min(0.0)
        along = along + speed * DT
        if action.offset is not None:
            most = STEEPEST * speed * DT
            change = torch.minimum(torch.maximum(action.offset - offset, -most), most)
            slope = change / (speed * DT).clamp_min(1e-6)
            offset = offset + change
    return torch.stack([p for p, _, _ in poses]), torch.stack([h for _, h, _ in poses]), torch.stack([v for _, _, v in poses])


def _observed(
    step: int, state: tuple[Tensor, Tensor, Tensor], size: Tensor, frame: Tensor, present: Tensor, paths: Paths
) -> Observation:
    """What S drivers see: `state` are their distance along the path, offset and speed, `frame` (6, S, M) is that of `Replay`."""
    (along, offset, speed), (length, width) = state, size.unbind(-1)
    place, left, half_length, half_width, speed_along, speed_across = frame
    return Observation(
        step=step,
        along=along,
        offset=offset,
        speed=speed,
        length=length,
        width=width,
        speed_limit=paths.speed_limit.gather(1, paths.row((along + 0.5 * length)[:, None]))[:, 0],
        ahead=place - along[:, None],
        left=left,
        half_length=half_length,
        half_width=half_width,
        speed_along=speed_along,
        speed_across=speed_across,
        present=present,
        paths=paths,
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


def _padded(paths: TargetPaths, rows: int) -> Paths:
    """The paths as tensors, with the last one repeated up to `rows`."""
    index = np.minimum(np.arange(rows), len(paths) - 1)
    point = torch.from_numpy(paths.point[index])
    step = point[:, 1:] - point[:, :-1]
    heading = torch.atan2(step[..., 1], step[..., 0])
    last = torch.from_numpy(paths.length[index]).long() - 1  # beyond it points repeat and have no direction
    column = torch.minimum(torch.arange(point.shape[1])[None], last[:, None])
    return Paths(
        point, heading.gather(1, column), torch.from_numpy(paths.speed_limit[index]), torch.from_numpy(paths.length[index])
    )
