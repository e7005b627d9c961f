"""What BITS learns from: rasters of every vehicle of every log at many steps; goals, plans and predictions by imitation."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from drivegen.core.geometry import rotate, wrap_angle
from drivegen.core.scenario import DT
from drivegen.generators._bits.net import GOAL, HOLD, Plan, Seen, cell_of, numbers_of
from drivegen.generators._bits.raster import Painted, rasters, stretch
from drivegen.generators.shared.closed_loop import Crowd, Tracks
from drivegen.generators.shared.moments import Moments
from drivegen.generators.shared.objective import Objective

HELD_OUT = 1024
"""Validation examples that the loss is taken over, at most."""

TURN_WEIGHT = 5.0
"""Of a radian against a metre."""

GOAL_NOISE = (1.0, 0.5, 0.05, 0.5)
"""The policy is taught with goals that miss by so much (one sigma, units of GOAL), as those that are drawn do."""


@dataclass(frozen=True)
class Logs:
    """Logged scenes: who is where, and the painted lanes."""

    tracks: Tracks
    painted: Painted

    def __len__(self) -> int:
        return len(self.tracks.start) - 1

    @classmethod
    def none(cls) -> "Logs":
        """No scene."""
        return cls(Tracks.none(), Painted.none())


def told(painted: Painted, crowd: Crowd, box: NDArray[np.integer], horizon: float) -> tuple[Tensor, Tensor]:
    """Rasters and numbers that the network is told of vehicles `box` (R,), see `rasters`."""
    speed = np.hypot(crowd.state[box, 3], crowd.state[box, 4])
    numbers = numbers_of(*map(torch.from_numpy, (speed, crowd.size[box], crowd.kind[box])))
    return torch.from_numpy(rasters(painted, crowd, box, horizon)), numbers


class DrivingExamples:
    """Vehicles at steps: what they saw, and what they did until `horizon` steps later; at most `most`, evenly spread."""

    def __init__(self, logs: Logs, horizon: int, most: int | None = None) -> None:
        self.logs, self.horizon = logs, horizon
        self.moments = Moments(logs.tracks, HOLD, horizon, most=most)

    def __len__(self) -> int:
        return len(self.moments)

    def seen(self, rows: NDArray[np.integer]) -> tuple[Tensor, Tensor]:
        """Rasters and numbers that the network is told, for examples `rows` (b,)."""
        return told(self.logs.painted, *self.moments.crowds(rows), self.horizon * DT)

    def future(self, rows: NDArray[np.integer]) -> tuple[Tensor, ...]:
        """Place (b, Q, 2), turn (b, Q) and speed (b, Q) every HOLD steps, in each vehicle's frame, and whether it was seen."""
        tracks, (box, step) = self.logs.tracks, (part[:, None] for part in self.moments[rows])
        at = step + np.arange(HOLD, self.horizon + 1, HOLD)
        heading = tracks.heading[box, step]
        place = rotate(tracks.position[box, at] - tracks.position[box, step], -heading)
        turn = wrap_angle(tracks.heading[box, at] - heading).astype(np.float32)
        speed = np.hypot(tracks.velocity[box, at, 0], tracks.velocity[box, at, 1])
        return tuple(torch.from_numpy(a) for a in (place, turn, speed, tracks.valid[box, at]))


class BitsObjective(Objective):
    """The goal network by cross-entropy of the true cell and residuals there, the policy by the way to the true goal, which is
    not missed where examples are held out, the predictor by the way itself.
    """

    chunk = 128

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """By how much each goal misses (rows, GOAL)."""
        return (torch.randn(rows, GOAL, generator=generator) * torch.tensor(GOAL_NOISE),)

    def mean(
        self, model: nn.Module, examples: DrivingExamples, rows: NDArray[np.integer], device: torch.device, *drawn: Tensor
    ) -> Tensor:
        """See `Objective`."""
        pictures, numbers = examples.seen(rows)
        longer = torch.from_numpy(stretch(10 * numbers[:, 0].numpy(), examples.horizon * DT))
        pictures, numbers, longer = (t.to(device) for t in (pictures, numbers, longer))
        place, turn, speed, there = (t.to(device) for t in examples.future(rows))
        goal = torch.cat([place[:, -1], turn[:, -1:], speed[:, -1:]], dim=1)
        seen, plan, prediction = model(pictures, numbers, (goal + drawn[0] if drawn else goal)[:, None])
        plan = Plan(*(part[:, 0] for part in plan))
        return (
            goal_loss(Seen(*seen), goal, longer)
            + way_loss(plan, place, turn, there)
            + way_loss(Plan(*prediction), place, turn, there)
        )


def goal_loss(seen: Seen, goal: Tensor, stretch: Tensor) -> Tensor:
    """Cross-entropy of the cell of each goal (b, GOAL), and how far the goal of that cell is from it."""
    cell = cell_of(goal[:, :2], stretch)
    chosen = seen.goal[torch.arange(len(cell), device=cell.device), cell]
    weight = goal.new_tensor([1.0, 1.0, TURN_WEIGHT, 1.0])
    gap = functional.smooth_l1_loss(chosen * weight, goal * weight, reduction="none").sum(dim=1)
    return functional.cross_entropy(seen.logit, cell) + gap.mean()


def way_loss(plan: Plan, place: Tensor, turn: Tensor, there: Tensor) -> Tensor:
    """How far a plan (b, T) is from the way (b, Q) that was driven, every HOLD steps."""
    at = slice(HOLD - 1, None, HOLD)
    gap = functional.smooth_l1_loss(plan.place[:, at], place, reduction="none").sum(dim=-1)
    gap = gap + functional.smooth_l1_loss(TURN_WEIGHT * plan.turn[:, at], TURN_WEIGHT * turn, reduction="none")
    return (gap * there).sum(dim=1).div(there.sum(dim=1).clamp(min=1)).mean()
