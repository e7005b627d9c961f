"""Where the targets are, and how they move along their paths.

On its path a target with acceleration a takes the speed max(0, v + a dt) and moves on by that (the Euler step that SUMO takes,
too); a is kept within limits, and an offset that the driver asks for is approached at most at STEEPEST to the path.
"""

import math
from dataclasses import dataclass, fields

import torch
from torch import Tensor

from drivegen.core.scenario import DT
from drivegen.world.observation import PATH_SPACING, Action, Paths

HARDEST_BRAKING, FASTEST_START = 9.0, 4.0
"""[m/s2] Limits of the acceleration, whatever a driver asks for."""

STEEPEST = 0.3
"""Largest slope towards a wanted offset [m across per m along]."""

_MOST_ACROSS = STEEPEST / math.hypot(1.0, STEEPEST)  # m per m driven


@dataclass(frozen=True)
class Ego:
    """R targets.

    Attributes:
        along, offset: (R,) [m] along their paths and to the left of them. course: (R,) [rad] their headings, seen from the paths.
        speed: (R,) [m/s]. position: (R, 2) [m]. heading: (R,) [rad]. wheel: (R,) [rad] angle of the front wheels; 0 on paths.
    """

    along: Tensor
    offset: Tensor
    course: Tensor
    speed: Tensor
    position: Tensor
    heading: Tensor
    wheel: Tensor

    @classmethod
    def at_start(cls, speed: Tensor, paths: Paths) -> "Ego":
        """Abreast of the first point of each path."""
        zero = torch.zeros_like(speed)
        return _posed(zero, zero, zero, speed, paths)

    def __getitem__(self, chosen: Tensor) -> "Ego":
        """The targets `chosen` (R,), copied."""
        return Ego(*(getattr(self, field.name)[chosen] for field in fields(self)))

    def put(self, rows: Tensor, fresh: "Ego") -> None:
        """Overwrite `rows` by those of `fresh`."""
        for field in fields(self):
            getattr(self, field.name)[rows] = getattr(fresh, field.name)


def on_path(ego: Ego, action: Action, paths: Paths, length: Tensor) -> Ego:
    """One step along the paths."""
    del length
    speed = (ego.speed + action.acceleration.clamp(-HARDEST_BRAKING, FASTEST_START) * DT).clamp_min(0.0)
    wanted = torch.zeros_like(speed) if action.offset is None else action.offset
    way = speed * DT
    across = torch.minimum(torch.maximum(wanted - ego.offset, -_MOST_ACROSS * way), _MOST_ACROSS * way)
    along = (way**2 - across**2).sqrt()
    return _posed(ego.along + along, ego.offset + across, torch.atan2(across, along), speed, paths)


def _posed(along: Tensor, offset: Tensor, course: Tensor, speed: Tensor, paths: Paths) -> Ego:
    start, beyond, heading = foot(along, paths)
    cos, sin = heading.cos(), heading.sin()
    position = start + beyond[:, None] * torch.stack([cos, sin], -1) + offset[:, None] * torch.stack([-sin, cos], -1)
    return Ego(along, offset, course, speed, position, heading + course, torch.zeros_like(speed))


def foot(along: Tensor, paths: Paths) -> tuple[Tensor, Tensor, Tensor]:
    """The path point (R, 2) at or before `along` (R,), the way (R,) beyond it [m], and the path's heading (R,) there [rad].

    Off the ends the path goes straight on.
    """
    row = paths.row(along[:, None])
    start = paths.point.gather(1, row[..., None].expand(-1, -1, 2))[:, 0]
    return start, along - row[:, 0] * PATH_SPACING, paths.heading.gather(1, row)[:, 0]
