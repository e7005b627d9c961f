"""What TrafficGen learns from: every vehicle of every log at many steps, and the loss of its motion modes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from drivegen.generators._closed_loop import Tracks
from drivegen.generators._trafficgen.net import KNOT, Modes
from drivegen.generators._trafficgen.placement import PlacementExamples, Regions, placement_loss
from drivegen.generators._trafficgen.vectors import LaneVectors, Surroundings
from drivegen.geometry import rotate, wrap_angle

HELD_OUT, HELD_OUT_CHUNK = 2048, 256
"""Validation examples that the loss is taken over, drawn once, and how many go through the network at once."""

TURN_WEIGHT = 5.0
"""Of a radian against a metre and a metre per second."""

PLACEMENT_EVERY, PLACEMENT_WEIGHT = 16, 0.1
"""One row in so many of a batch is one of placement as well; its loss is large but shares no weights with the motion's."""


@dataclass(frozen=True)
class Logs:
    """Logged scenes: who is where, and the lanes."""

    tracks: Tracks
    vectors: LaneVectors

    def __len__(self) -> int:
        return len(self.tracks.start) - 1

    @classmethod
    def joined(cls, parts: Sequence["Logs"]) -> "Logs":
        """All scenes in order."""
        return cls(Tracks.joined([p.tracks for p in parts]), LaneVectors.joined([p.vectors for p in parts]))


class MotionExamples:
    """Vehicles at steps: surroundings and what they did next.

    Attributes:
        box, step: (E,) of the logs. knots: Q of what is predicted.
    """

    def __init__(self, logs: Logs, knots: int, counts: tuple[int, int], look: float, most: int | None = None) -> None:
        self.logs, self.knots, self.counts, self.look = logs, knots, counts, look
        self.box, self.step = logs.tracks.examples(KNOT, KNOT)
        self.scene = logs.tracks.scene
        if most is not None and len(self.box) > most:
            kept = np.linspace(0, len(self.box) - 1, most).astype(np.intp)
            self.box, self.step = self.box[kept], self.step[kept]

    def surroundings(self, rows: NDArray[np.integer]) -> tuple[Tensor, ...]:
        """Inputs of the network for examples `rows` (b,)."""
        tracks, scene, step = self.logs.tracks, self.scene[self.box[rows]], self.step[rows]
        crowd = tracks.at(scene, step)
        box = crowd.start[:-1] + self.box[rows] - tracks.start[scene]
        group = np.arange(len(rows))
        around = Surroundings.of(self.logs.vectors, crowd, group, box, scene, step, self.counts, self.look)
        return tuple(torch.from_numpy(a) for a in (around.lanes, around.lane_there, around.boxes, around.box_there))

    def future(self, rows: NDArray[np.integer]) -> tuple[Tensor, ...]:
        """Place (b, Q, 2), velocity (b, Q, 2) and turn (b, Q) at the knots, in each vehicle's frame, and whether it was seen."""
        tracks, box, step = self.logs.tracks, self.box[rows, None], self.step[rows, None]
        wanted = step + KNOT * np.arange(1, self.knots + 1)
        at = np.minimum(wanted, tracks.valid.shape[1] - 1)
        heading = tracks.heading[box, step]
        place = rotate(tracks.position[box, at] - tracks.position[box, step], -heading)
        velocity = rotate(tracks.velocity[box, at], -heading)
        turn = wrap_angle(tracks.heading[box, at] - heading).astype(np.float32)
        return tuple(torch.from_numpy(a) for a in (place, velocity, turn, tracks.valid[box, at] & (wanted == at)))


def motion_loss(modes: Modes, place: Tensor, velocity: Tensor, turn: Tensor, seen: Tensor) -> Tensor:
    """Winner takes all: motion of the mode that ends nearest, and the cross-entropy of the odds of just that mode."""
    last = seen.shape[1] - 1 - seen.flip(1).int().argmax(dim=1)
    rows = torch.arange(len(seen), device=seen.device)
    end_gap = (modes.place[rows, :, last] - place[rows, last][:, None]).norm(dim=-1)
    best = end_gap.detach().argmin(dim=1)
    weight = seen.float() / seen.sum(dim=1, keepdim=True).clamp(min=1)

    def gap(found: Tensor, true: Tensor) -> Tensor:
        each = functional.smooth_l1_loss(found, true, reduction="none")
        return ((each.sum(dim=-1) if each.dim() == 3 else each) * weight).sum(dim=1).mean()

    motion = gap(modes.place[rows, best], place) + gap(modes.velocity[rows, best], velocity)
    turning = gap(TURN_WEIGHT * modes.turn[rows, best], TURN_WEIGHT * turn)
    return motion + turning + functional.cross_entropy(modes.logit, best)


class TrafficGenObjective:
    """See `training.loop.Objective`: the loss of the motion, and beside it that of the placement, which shares no weights."""

    def __init__(self, train: MotionExamples, validation: MotionExamples, placement: PlacementExamples) -> None:
        self.train, self.held_out, self.placement = train, validation, placement
        self.size = len(train.box)

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """One number in [0, 1) for which scene a row places vehicles in, one for what share of them is given."""
        return (torch.rand(rows, 2, generator=generator),)

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        """Mean over the examples; every PLACEMENT_EVERY-th row is one of placement, too."""
        chance = drawn[0][::PLACEMENT_EVERY].cpu().numpy()
        placed = self._placed(model, chance, rows.device)
        return self._loss(model, self.train, rows.cpu().numpy(), rows.device) + PLACEMENT_WEIGHT * placed

    def validation(self, model: nn.Module) -> float:
        """That of the motion alone, over examples spread evenly over the validation logs: the figure that chooses the weights."""
        count, device = len(self.held_out.box), next(model.parameters()).device
        parts = [np.arange(low, min(low + HELD_OUT_CHUNK, count)) for low in range(0, count, HELD_OUT_CHUNK)]
        total = sum(len(rows) * float(self._loss(model, self.held_out, rows, device)) for rows in parts)
        return total / count if count else float("nan")

    def _loss(self, model: nn.Module, examples: MotionExamples, rows: NDArray[np.integer], device: torch.device) -> Tensor:
        modes = model("motion", *(t.to(device) for t in examples.surroundings(rows)))
        return motion_loss(Modes(*modes), *(t.to(device) for t in examples.future(rows)))

    def _placed(self, model: nn.Module, chance: NDArray[np.floating], device: torch.device) -> Tensor:
        """Loss of the placement for examples and shares drawn by `chance` (b, 2)."""
        inputs, wanted = self.placement.of((chance[:, 0] * len(self.placement.scene)).astype(np.intp), chance[:, 1])
        regions = Regions(*model("placement", *(t.to(device) for t in inputs)))
        return placement_loss(regions, wanted.to(device))
