"""What the others of scenes plan to do: their replayed motion as tables that can be looked up between two steps, too."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.geometry import unit
from drivegen.world.observation import STANDING
from drivegen.world.scenes import Scenes

X, Y, HEADING, COS, SIN, ARC = range(6)
"""Channels of `Plan.pose`; ARC is the way driven since step 0 [m]."""


@dataclass(frozen=True)
class Plan:
    """Plans of M others in S scenes of T steps; row s * T + t is scene s at step t.

    Attributes:
        pose: (S * T, 6, M) by channel, [m] and [rad]. speed: (S * T, M) [m/s], 0 where nobody is present.
        resume: (S * T, M) float32 the first step from this one on at which the plan does not stand; T if none.
    """

    pose: Tensor
    speed: Tensor
    resume: Tensor

    @classmethod
    def of(cls, scenes: Scenes) -> Self:
        """The plans of `scenes`, on their device."""
        others, device = scenes.replay, scenes.steps.device
        speed = np.hypot(others.frame[:, :, 4], others.frame[:, :, 5]) * others.valid
        both = others.valid[:, 1:] & others.valid[:, :-1]
        driven = np.hypot(*np.moveaxis(np.diff(others.position, axis=1), -1, 0)) * both
        arc = np.concatenate([np.zeros_like(driven[:, :1]), np.cumsum(driven, axis=1)], axis=1)
        direction = unit(others.heading)
        heading = np.unwrap(others.heading, axis=1)  # so that it can be interpolated
        channels = (*np.moveaxis(others.position, -1, 0), heading, *np.moveaxis(direction, -1, 0), arc)
        pose = np.stack(channels, axis=2).astype(np.float32)
        tables = (pose, speed, _resume(speed))
        return cls(*(torch.from_numpy(table.astype(np.float32)).flatten(0, 1).to(device) for table in tables))


def _resume(speed: NDArray[np.floating]) -> NDArray[np.integer]:
    steps = speed.shape[1]
    moves = np.where(speed > STANDING, np.arange(steps)[:, None], steps)
    return np.minimum.accumulate(moves[:, ::-1], axis=1)[:, ::-1]


def between(table: Tensor, before: Tensor, after: Tensor, share: Tensor) -> Tensor:
    """Channels (R, C, M) of a `table` (A, C, M) between its rows `before` and `after` (R, M), `share` (R, M) of the way."""
    channels, others = table.shape[1:]
    flat = table.view(-1)
    column = torch.arange(others, device=table.device) + others * torch.arange(channels, device=table.device)[:, None]
    first = flat.take((before * (channels * others))[:, None] + column)
    second = flat.take((after * (channels * others))[:, None] + column)
    return first + share[:, None] * (second - first)
