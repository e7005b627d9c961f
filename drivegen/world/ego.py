"""Where the targets are, and how they move along their paths.

On its path a target with acceleration a takes the speed max(0, v + a dt) and moves on by that (the Euler step that SUMO takes,
too); an offset that the driver asks for is approached at most at STEEPEST to the path.
"""

from dataclasses import dataclass, fields

import torch
from torch import Tensor

from drivegen.core.scenario import DT
from drivegen.drivers.base import PATH_SPACING, Action, Paths

STEEPEST = 0.3
"""Largest slope towards a wanted offset [m across per m along]."""


@dataclass(frozen=True)
class Ego:
    """R targets.

    Attributes:
        along, offset: (R,) [m] along their paths and to the left of them. slope: (R,) of the offset along the path.
        speed: (R,) [m/s]. position: (R, 2) [m]. heading: (R,) [rad].
    """

    along: Tensor
    offset: Tensor
    slope: Tensor
    speed: Tensor
    position: Tensor
    heading: Tensor

    @classmethod
    def at_start(cls, speed: Tensor, paths: Paths) -> "Ego":
        """Abreast of the first point of each path."""
        zero = torch.zeros_like(speed)
        return _posed(zero, zero, zero, speed, paths)

    def put(self, rows: Tensor, fresh: "Ego") -> None:
        """Overwrite `rows` by those of `fresh`."""
        for field in fields(self):
            getattr(self, field.name)[rows] = getattr(fresh, field.name)


def on_path(ego: Ego, action: Action, paths: Paths) -> Ego:
    """One step along the paths."""
    speed = (ego.speed + action.acceleration * DT).clamp_min(0.0)
    along = ego.along + speed * DT
    offset, slope = ego.offset, ego.slope
    if action.offset is not None:
        most = STEEPEST * speed * DT
        change = torch.minimum(torch.maximum(action.offset - offset, -most), most)
        slope = change / (speed * DT).clamp_min(1e-6)
        offset = offset + change
    return _posed(along, offset, slope, speed, paths)


def _posed(along: Tensor, offset: Tensor, slope: Tensor, speed: Tensor, paths: Paths) -> Ego:
    row = paths.row(along[:, None])
    heading = paths.heading.gather(1, row)[:, 0]
    cos, sin = heading.cos(), heading.sin()
    start = paths.point.gather(1, row[..., None].expand(-1, -1, 2))[:, 0]
    beyond = along - row[:, 0] * PATH_SPACING  # off the ends the path goes straight on
    position = start + beyond[:, None] * torch.stack([cos, sin], -1) + offset[:, None] * torch.stack([-sin, cos], -1)
    return Ego(along, offset, slope, speed, position, heading + slope.atan())
