"""BITS's networks: a spatial goal network (small U-Net), a goal-conditioned policy and a predictor, with unicycle dynamics."""

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from drivegen.core.scenario import DT, VehicleKind
from drivegen.generators._bits.raster import BEHIND, CHANNELS, COLUMNS, FAST, PIXEL, ROWS

GOAL_ROWS, GOAL_COLUMNS = ROWS // 2, COLUMNS // 2
"""Cells of the heat map."""

CELLS = GOAL_ROWS * GOAL_COLUMNS

HOLD = 5
"""Steps for which an action is held."""

TOLD = 3 + 3
"""Speed [10 m/s], length [5 m], width [2 m], kind of motor vehicle (one-hot: car, truck, bus)."""

GOAL = 4
"""x, y [m], turn [rad], speed [m/s] at the horizon, in the vehicle's frame."""

ACCELERATION, CURVATURE = (-8.0, 5.0), 0.2
"""Bounds of the actions [m/s2], [1/m]."""

LEAST_WAY = 2.0
"""Below this distance [m] a goal tells no curvature."""


class Seen(NamedTuple):
    """What the goal network makes of R rasters.

    Attributes:
        code: (R, D) for policy and predictor. logit: (R, CELLS) of the heat map, row by row from ahead to behind.
        goal: (R, CELLS, GOAL) the goal of each cell: its centre and residual, turn, speed.
    """

    code: Tensor
    logit: Tensor
    goal: Tensor


class Plan(NamedTuple):
    """Motion at steps 1..T in the vehicle's frame: place (..., T, 2) [m], turn (..., T) [rad], speed (..., T) [m/s]."""

    place: Tensor
    turn: Tensor
    speed: Tensor


class BitsNet(nn.Module):
    """All three; `steps` is the horizon, a multiple of HOLD."""

    centres: Tensor

    def __init__(self, width: int, steps: int) -> None:
        super().__init__()
        self.steps = steps
        narrow, middle, wide = width // 4, width // 2, 3 * width // 4
        self.down = nn.ModuleList(
            nn.Sequential(nn.Conv2d(a, b, 3, stride=2, padding=1), nn.GroupNorm(4, b), nn.ReLU())
            for a, b in ((CHANNELS, narrow), (narrow, middle), (middle, wide))
        )
        self.code = nn.Sequential(nn.Linear(wide * CELLS // 16 + TOLD, width), nn.LayerNorm(width), nn.ReLU(), nn.Dropout(0.1))
        self.spread, self.lift, self.beside = nn.Linear(width, middle), nn.Conv2d(wide, middle, 1), nn.Conv2d(middle, middle, 1)
        self.up = nn.Sequential(nn.GroupNorm(4, middle), nn.ReLU(), nn.Conv2d(middle, middle, 3, padding=1), nn.ReLU())
        self.heads, self.fine = nn.Conv2d(middle, 4 * (1 + GOAL), 1), nn.Conv2d(narrow, 1 + GOAL, 1)
        self.policy = _mlp(width + TOLD + GOAL + 2, width, 2 * steps // HOLD)
        self.predictor = _mlp(width + TOLD, width, 2 * steps // HOLD)
        along = (GOAL_ROWS - torch.arange(GOAL_ROWS) - 0.5) * 2 * PIXEL[0] - BEHIND
        across = (GOAL_COLUMNS / 2 - torch.arange(GOAL_COLUMNS) - 0.5) * 2 * PIXEL[1]
        self.register_buffer("centres", torch.cartesian_prod(along, across), persistent=False)

    def forward(self, pictures: Tensor, numbers: Tensor, goal: Tensor) -> tuple[Seen, Plan, Plan]:
        """What is seen, the plans (R, M, T) to goals (R, M, GOAL) and the predictions (R, T)."""
        seen = self.see(pictures, numbers)
        return seen, self.plan(seen.code, numbers, goal), self.predict(seen.code, numbers)

    def see(self, pictures: Tensor, numbers: Tensor) -> Seen:
        """Rasters (R, CHANNELS, ROWS, COLUMNS) and numbers (R, TOLD) of each vehicle."""
        fine = self.down[0](pictures)
        middle = self.down[1](fine)
        coarse = self.down[2](middle)
        code = self.code(torch.cat([coarse.flatten(1), numbers], dim=1))
        lifted = functional.interpolate(self.lift(coarse), scale_factor=2.0)
        joined = self.up(lifted + self.beside(middle) + self.spread(code)[:, :, None, None])
        maps = (functional.pixel_shuffle(self.heads(joined), 2) + self.fine(fine)).flatten(2)
        along, across, turn, gain = maps[:, 1:].unbind(dim=1)
        speed = 10.0 * numbers[:, :1]
        x = (self.centres[:, 0] + along) * self.stretch(numbers)[:, None]
        goal = torch.stack([x, self.centres[:, 1] + across, 0.2 * turn, speed + 5 * gain], dim=2)
        return Seen(code, maps[:, 0], goal)

    def stretch(self, numbers: Tensor) -> Tensor:
        """(R,) see `raster.stretch`."""
        return (numbers[:, 0] * (10.0 * self.steps * DT / FAST)).clamp(min=1.0)

    def plan(self, code: Tensor, numbers: Tensor, goal: Tensor) -> Plan:
        """How each of M goals (R, M, GOAL) is driven to."""
        speed, seconds = 10.0 * numbers[:, None, 0], self.steps * DT
        gain = (2 * (goal[..., 0] - speed * seconds) / seconds**2).clamp(*ACCELERATION)
        bend = torch.where(goal[..., 0] > LEAST_WAY, goal[..., 2] / goal[..., 0].clamp(min=LEAST_WAY), 0.0).clamp(
            -CURVATURE, CURVATURE
        )
        scale = goal.new_tensor([25.0, 5.0, 1.0, 10.0])
        given = torch.cat([code, numbers], dim=1)[:, None].expand(-1, goal.shape[1], -1)
        raw = self.policy(torch.cat([given, goal / scale, gain[..., None], 20 * bend[..., None]], dim=-1))
        raw = raw.unflatten(-1, (2, -1))
        return unicycle(speed, gain[..., None] + 2 * raw[..., 0, :], bend[..., None] + 0.05 * raw[..., 1, :])

    def predict(self, code: Tensor, numbers: Tensor) -> Plan:
        """What each vehicle is expected to do, (R, T)."""
        raw = self.predictor(torch.cat([code, numbers], dim=1)).unflatten(-1, (2, -1))
        return unicycle(10.0 * numbers[:, 0], 2 * raw[:, 0], 0.05 * raw[:, 1])


def unicycle(speed: Tensor, acceleration: Tensor, curvature: Tensor) -> Plan:
    """Drive from `speed` (...) with actions (..., A) [m/s2], [1/m], each held for HOLD steps; nobody drives backward."""
    gain = acceleration.clamp(*ACCELERATION).repeat_interleave(HOLD, dim=-1)
    bend = curvature.clamp(-CURVATURE, CURVATURE).repeat_interleave(HOLD, dim=-1)
    after = (speed[..., None] + (gain * DT).cumsum(dim=-1)).clamp(min=0)
    before = torch.cat([speed[..., None].expand_as(after[..., :1]), after[..., :-1]], dim=-1)
    way = (before + after) * (DT / 2)
    turned = bend * way
    turn = turned.cumsum(dim=-1)
    middle = turn - turned / 2
    place = torch.stack([way * middle.cos(), way * middle.sin()], dim=-1).cumsum(dim=-2)
    return Plan(place, turn, after)


def cell_of(place: Tensor, stretch: Tensor) -> Tensor:
    """Heat map cell (...) of places (..., 2) [m] on rasters stretched by (...); those beyond the map belong to its edge."""
    row = (GOAL_ROWS - 1 - ((place[..., 0] / stretch + BEHIND) / (2 * PIXEL[0])).floor()).clamp(0, GOAL_ROWS - 1)
    column = (GOAL_COLUMNS / 2 - 1 - (place[..., 1] / (2 * PIXEL[1])).floor()).clamp(0, GOAL_COLUMNS - 1)
    return (row * GOAL_COLUMNS + column).long()


def numbers_of(speed: Tensor, size: Tensor, kind: Tensor) -> Tensor:
    """(R, TOLD) from speeds (R,) [m/s], sizes (R, 2) [m] and kinds (R,)."""
    kinds = torch.stack([kind == k for k in (VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS)], dim=1)
    return torch.cat([speed[:, None] / 10, size / size.new_tensor([5.0, 2.0]), kinds.float()], dim=1)


def _mlp(given: int, width: int, wanted: int) -> nn.Sequential:
    """Three layers; at first what it gives is near zero."""
    last = nn.Linear(width, wanted)
    nn.init.normal_(last.weight, std=0.01)
    nn.init.zeros_(last.bias)
    return nn.Sequential(nn.Linear(given, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), last)
