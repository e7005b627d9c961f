"""What TrafficGen learns from: every vehicle of every log at many steps, and the loss of its motion modes.

Driven on by what it predicted, a vehicle is soon somewhat beside its lane or turned against it, as no log is. So some
examples are begun like that, and end where the log went.
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from drivegen.core.geometry import rotate, unit, wrap_angle
from drivegen.core.scenario import DT
from drivegen.core.settings import NotNegative, Share
from drivegen.generators._trafficgen.net import KNOT, Modes
from drivegen.generators._trafficgen.placement import PlacementExamples, Regions, Wanted, placement_loss
from drivegen.generators._trafficgen.vectors import Surroundings
from drivegen.generators.shared.lanes import Logs
from drivegen.generators.shared.moments import Moments
from drivegen.generators.shared.objective import Objective

HELD_OUT = 1024
"""Validation examples that the loss is taken over, at most."""

RECOVERY = 3.0
"""[s] in which who was disturbed is to be back on the logged way."""

MOVING, BRISK = 2.0, 5.0
"""[m/s] Slower than the one, a velocity says nothing of a heading; slower than the other, a vehicle is disturbed less."""

TURN_WEIGHT = 5.0
"""Of a radian against a metre and a metre per second."""

PLACEMENT_EVERY, PLACEMENT_WEIGHT = 16, 0.1
"""One row in so many of a batch is one of placement as well; its loss is large but shares no weights with the motion's."""


@dataclass(frozen=True)
class Disturbance:
    """How examples are begun that are not begun as logged.

    Attributes:
        share: of the examples. beside: [m] at most from the logged place, left or right. turned: [rad] at most.
    """

    share: Share
    beside: NotNegative
    turned: NotNegative

    def of(self, logged: NDArray[np.float32], chance: NDArray[np.float32]) -> NDArray[np.float32]:
        """States (b, 5) moved aside and turned by uniform `chance` (b, 3) in [0, 1); who stands stays."""
        heading, velocity = logged[:, 2], logged[:, 3:5]
        strength = (chance[:, 0] < self.share) * np.minimum(np.hypot(*velocity.T) / BRISK, 1.0)
        beside, turned = (strength[:, None] * (2 * chance[:, 1:] - 1) * (self.beside, self.turned)).T
        place = logged[:, :2] + unit(heading + np.pi / 2) * beside[:, None]
        return np.column_stack([place, heading + turned, rotate(velocity, turned)]).astype(np.float32)


class MotionExamples:
    """Vehicles at steps: surroundings and what they did next, at Q `knots`; at most `most`, evenly spread."""

    def __init__(self, logs: Logs, knots: int, counts: tuple[int, int], look: float, most: int | None = None) -> None:
        self.logs, self.knots, self.counts, self.look = logs, knots, counts, look
        self.moments = Moments(logs.tracks, KNOT, KNOT, most=most)

    def __len__(self) -> int:
        return len(self.moments)

    def logged(self, rows: NDArray[np.integer]) -> NDArray[np.float32]:
        """States (b, 5) of examples `rows` (b,): place, heading, velocity."""
        tracks, (box, step) = self.logs.tracks, self.moments[rows]
        return np.column_stack([tracks.position[box, step], tracks.heading[box, step], tracks.velocity[box, step]])

    def surroundings(self, rows: NDArray[np.integer], state: NDArray[np.float32]) -> tuple[Tensor, ...]:
        """Inputs of the network for examples `rows` (b,) that are in `state` (b, 5), the others where the log has them."""
        crowd, box = self.moments.crowds(rows)
        crowd.state[box] = state
        return Surroundings.of(self.logs.lanes, crowd, box, self.counts, self.look).tensors()

    def future(self, rows: NDArray[np.integer], state: NDArray[np.float32]) -> tuple[Tensor, ...]:
        """Place (b, Q, 2), velocity (b, Q, 2) and turn (b, Q) at the knots, in the frames of `state`, and whether it was seen.

        From another state than the logged one, a cubic leads back to the logged way within RECOVERY.
        """
        tracks, (box, step) = self.logs.tracks, (part[:, None] for part in self.moments[rows])
        ahead = KNOT * np.arange(1, self.knots + 1)
        at = np.minimum(step + ahead, tracks.valid.shape[1] - 1)
        off = (state - self.logged(rows))[:, None]
        u = np.minimum(ahead * DT / RECOVERY, 1.0).astype(np.float32)[:, None]
        back = off[..., :2] * (2 * u**3 - 3 * u**2 + 1) + off[..., 3:] * RECOVERY * (u**3 - 2 * u**2 + u)
        backing = off[..., :2] / RECOVERY * (6 * u**2 - 6 * u) + off[..., 3:] * (3 * u**2 - 4 * u + 1)
        logged, heading = tracks.velocity[box, at], state[:, 2:3]
        velocity = logged + backing
        moving = np.minimum(np.linalg.norm(velocity, axis=-1), np.linalg.norm(logged, axis=-1)) > MOVING
        slant = np.where(moving, _direction(velocity) - _direction(logged), 0.0)
        turn = wrap_angle(tracks.heading[box, at] + slant - heading).astype(np.float32)
        place = rotate(tracks.position[box, at] + back - state[:, None, :2], -heading)
        truth = place, rotate(velocity, -heading), turn, tracks.valid[box, at] & (step + ahead == at)
        return tuple(torch.from_numpy(a) for a in truth)


def _direction(velocity: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(np.arctan2(velocity[..., 1], velocity[..., 0]))


def motion_loss(modes: Modes, place: Tensor, velocity: Tensor, turn: Tensor, seen: Tensor) -> Tensor:
    """Winner takes all: motion of the mode that ends nearest, and the cross-entropy of the odds of just that mode."""
    last = seen.shape[1] - 1 - seen.flip(1).int().argmax(dim=1)
    rows = torch.arange(len(seen), device=seen.device)
    end_gap = (modes.place[rows, :, last] - place[rows, last][:, None]).norm(dim=-1)
    best = end_gap.detach().argmin(dim=1)
    weight = seen.float() / seen.sum(dim=1, keepdim=True).clamp(min=1)

    def gap(predicted: Tensor, true: Tensor) -> Tensor:
        each = functional.smooth_l1_loss(predicted, true, reduction="none")
        return ((each.sum(dim=-1) if each.dim() == 3 else each) * weight).sum(dim=1).mean()

    motion = gap(modes.place[rows, best], place) + gap(modes.velocity[rows, best], velocity)
    turning = gap(TURN_WEIGHT * modes.turn[rows, best], TURN_WEIGHT * turn)
    return motion + turning + functional.cross_entropy(modes.logit, best)


class TrafficGenObjective(Objective):
    """The loss of the motion, and beside it that of the placement, which shares no weights: one of every PLACEMENT_EVERY rows
    is one of placement, too. Examples that are held out are begun as logged, and nobody is placed.
    """

    chunk = 256

    def __init__(
        self, train: MotionExamples, held_out: MotionExamples, placement: PlacementExamples, disturbance: Disturbance
    ) -> None:
        super().__init__(train, held_out)
        self.placement, self.disturbance = placement, disturbance

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """In [0, 1): how a row is disturbed (3), which scene it places vehicles in and what share of them is given (2)."""
        return torch.rand(rows, 3, generator=generator), torch.rand(rows, 2, generator=generator)

    def mean(
        self, model: nn.Module, examples: MotionExamples, rows: NDArray[np.integer], device: torch.device, *drawn: Tensor
    ) -> Tensor:
        """See `Objective`."""
        state = examples.logged(rows)
        if drawn:
            state = self.disturbance.of(state, drawn[0].cpu().numpy())
        modes = model("motion", *(t.to(device) for t in examples.surroundings(rows, state)))
        motion = motion_loss(Modes(*modes), *(t.to(device) for t in examples.future(rows, state)))
        return motion + PLACEMENT_WEIGHT * self._placed(model, drawn[1][::PLACEMENT_EVERY], device) if drawn else motion

    def _placed(self, model: nn.Module, drawn: Tensor, device: torch.device) -> Tensor:
        """Loss of the placement for examples and shares drawn by `drawn` (b, 2)."""
        chance = drawn.cpu().numpy()
        inputs, wanted = self.placement.of((chance[:, 0] * len(self.placement.moments)).astype(np.intp), chance[:, 1])
        regions = Regions(*model("placement", *(t.to(device) for t in inputs)))
        return placement_loss(regions, Wanted(*(t.to(device) for t in wanted)))
