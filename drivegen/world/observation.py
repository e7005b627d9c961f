"""What a driver sees and what it answers: everything about others is in the frame of the target's path."""

from dataclasses import dataclass, fields

import torch
from torch import Tensor

from drivegen.core.signals import SignalState

PATH_SPACING = 1.0
"""Distance between points of a path [m]."""

STANDING = 0.1
"""Slower than this [m/s] a vehicle stands."""


@dataclass(frozen=True)
class Paths:
    """S paths with a point every PATH_SPACING; rows are padded by repeating the end.

    Attributes:
        point: (S, P, 2) float32 [m].
        heading: (S, P) float32 [rad].
        speed_limit: (S, P) float32 [m/s], NaN where unknown.
        length: (S,) float32 [m] valid length of each path.
    """

    point: Tensor
    heading: Tensor
    speed_limit: Tensor
    length: Tensor

    def __getitem__(self, chosen: Tensor) -> "Paths":
        """The paths `chosen` (R,), copied."""
        return Paths(*(getattr(self, field.name)[chosen] for field in fields(self)))

    def put(self, rows: Tensor, paths: "Paths") -> None:
        """Overwrite `rows` by those of `paths`."""
        for field in fields(self):
            getattr(self, field.name)[rows] = getattr(paths, field.name)

    def row(self, along: Tensor) -> Tensor:
        """(S, ...) int64 index of the path point at or before `along` (S, ...) [m] from which a segment of the path goes on."""
        last = (self.length - PATH_SPACING).reshape(-1, *[1] * (along.dim() - 1))
        return torch.minimum(along.clamp_min(0.0), last).div(PATH_SPACING).long()

    def position(self, along: Tensor) -> Tensor:
        """(S, D, 2) points [m] at distances `along` (S, D); beyond the ends the path goes straight on."""
        row = self.row(along)
        inside = self.point.gather(1, row[..., None].expand(-1, -1, 2))
        heading = self.heading.gather(1, row)
        beyond = (along - row * PATH_SPACING)[..., None]
        return inside + beyond * torch.stack([heading.cos(), heading.sin()], -1)


@dataclass(frozen=True)
class Rules:
    """What signals, signs and right of way ask at the next line on the paths of S targets, with M others.

    Attributes:
        distance: (S,) [m] from the target's front to the line, inf where none is ahead.
        signal: (S,) int64 SignalState there now. control: (S,) int64 LaneControl there.
        halted: (S,) bool, whether the target has stood before this line.
        arrives: (S, M) [s] until each other who has right of way is where its way meets the target's, at its present speed;
            0 if it is there, inf for those who have no right of way.
    """

    distance: Tensor
    signal: Tensor
    control: Tensor
    halted: Tensor
    arrives: Tensor


@dataclass(frozen=True)
class Observation:
    """What the drivers of S targets see at one step; everything about the M others is in the frame of the target's path.

    Attributes:
        step: (S,) int64 number of the step, 0 at the first frame.
        along: (S,) distance of the target's centre along its path [m]. offset: (S,) to the left of it [m].
        course: (S,) [rad] the target's heading, seen from its path.
        speed: (S,) [m/s]. length, width: (S,) of the target [m].
        speed_limit: (S,) [m/s] where the target's front is, NaN unknown.
        ahead: (S, M) distance of the others' centres ahead of the target's, along the path [m].
        left: (S, M) offset of their centres to the left of the path [m].
        half_length, half_width: (S, M) half the extent of their boxes along and across the path [m].
        speed_along, speed_across: (S, M) their velocity along the path and to the left [m/s].
        present: (S, M) bool, whether there is such a vehicle or person at this step.
        paths: the targets' paths.
        rules: what holds at the next line; None where the world does not look.
    """

    step: Tensor
    along: Tensor
    offset: Tensor
    course: Tensor
    speed: Tensor
    length: Tensor
    width: Tensor
    speed_limit: Tensor
    ahead: Tensor
    left: Tensor
    half_length: Tensor
    half_width: Tensor
    speed_along: Tensor
    speed_across: Tensor
    present: Tensor
    paths: Paths
    rules: Rules | None = None

    def limits_ahead(self, distances: Tensor) -> Tensor:
        """(S, D) speed limits [m/s] at `distances` (D,) [m] ahead of the target's front, NaN unknown."""
        front = self.along + 0.5 * self.length
        return self.paths.speed_limit.gather(1, self.paths.row(front[:, None] + distances))

    @property
    def red_line(self) -> Tensor:
        """(S,) [m] from the target's front to the line ahead where its signal is red, inf where it is not."""
        if self.rules is None:
            return torch.full_like(self.speed, torch.inf)
        return torch.where(self.rules.signal == SignalState.RED, self.rules.distance, torch.inf)


def runs_red(line: Tensor, moved: Tensor) -> Tensor:
    """(S,) whether targets whose `red_line` is at `line` (S,) [m] run that light if they get `moved` (S,) [m] farther now."""
    return (line > 0) & (moved >= line)


@dataclass(frozen=True)
class Action:
    """What S drivers decide for one step.

    Attributes:
        acceleration: (S,) [m/s2], kept between -9 and 4 (`ego.py`); a target never drives backwards.
        offset: (S,) [m] to the left of the path where the driver wants to be; None stands for 0, the path's line.
        steering: (S,) [rad] angle of the front wheels, to the left positive, where targets move freely; None on paths.
    """

    acceleration: Tensor
    offset: Tensor | None = None
    steering: Tensor | None = None
