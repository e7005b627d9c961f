"""What LCTGen learns from scenes: motion of the log's code, the prior of its action fields, placement."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core.geometry import rotate, wrap_angle
from drivegen.core.scenario import TARGET, Scenario
from drivegen.generators._lctgen.codes import PARTS, Action, logged_actions, state_code
from drivegen.generators._lctgen.net import LctgenNet, Placement
from drivegen.generators.shared.objective import Objective
from drivegen.generators.shared.vectors import Scenes, SceneTensors, displacement

NO_PIECE = -1

SCALES = np.array([5.0, 5.0, 1.0, 5.0, 5.0, 10.0])
"""Units of the ATTRIBUTES."""


@dataclass(frozen=True)
class Taught:
    """Scenes with their codes.

    Attributes:
        scenes: with futures. code: (S, A, 8) int64; an action that the log did not see is KEEP_SPEED.
        seen: (S, A, PARTS) bool actions that it did see.
        points, road, drawn: the pieces around the targets, as `points`, `piece` and `drawn` of `around_targets`.
        piece: (S, A) int64 the one of these that each vehicle stands on, NO_PIECE where none is near.
        attributes: (S, A, ATTRIBUTES) float32 of the vehicle on that piece, in units.
    """

    scenes: Scenes
    code: NDArray[np.int64]
    seen: NDArray[np.bool_]
    points: NDArray[np.float32]
    road: NDArray[np.float32]
    drawn: NDArray[np.bool_]
    piece: NDArray[np.int64]
    attributes: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.scenes)

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> Self:
        """Codes and places of those scenarios that have a log."""
        logged = [scenario for scenario in scenarios if scenario.log is not None]
        scenes, roads = Scenes.with_logs(logged), around_targets(logged)
        actions, seen = logged_actions(scenes)
        code = np.concatenate([state_code(scenes), np.where(seen, actions, Action.KEEP_SPEED)], axis=-1)
        return cls(scenes, code, seen, roads.points, roads.piece, roads.drawn, *places(scenes, roads))

    @classmethod
    def none(cls) -> Self:
        """No scene."""
        return cls.of([])

    def tensors(self, rows: NDArray[np.integer], device: torch.device) -> "_Tensors":
        """Scenes, the same with the roads around their targets, codes, actions seen, pieces and attributes of `rows` (b,)."""
        around, taught = (self.points, self.road, self.drawn), (self.code, self.seen, self.piece, self.attributes)
        points, road, drawn = (torch.from_numpy(a[rows]).to(device) for a in around)
        code, seen, piece, attributes = (torch.from_numpy(a[rows]).to(device) for a in taught)
        scenes = self.scenes[rows].tensors(device)
        return scenes, replace(scenes, points=points, piece=road, drawn=drawn), code, seen, piece, attributes


def around_targets(scenarios: Sequence[Scenario]) -> Scenes:
    """First frames of which the targets alone are known: pieces chosen by the others, too, would tell where these are."""
    return Scenes.of([replace(scenario, vehicles=scenario.vehicles[[TARGET]], log=None) for scenario in scenarios])


def places(scenes: Scenes, roads: Scenes) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """The piece of `roads` (S, A) that each vehicle of `scenes` is on, its attributes there (S, A, ATTRIBUTES), in units."""
    middle = roads.points.mean(axis=2)
    along = roads.points[:, :, -1] - roads.points[:, :, 0]
    heading = np.arctan2(along[..., 1], along[..., 0])
    gap = np.hypot(*np.moveaxis(scenes.position[:, :, None] - middle[:, None], -1, 0))
    turned = np.abs(wrap_angle(scenes.heading[:, :, None] - heading[:, None]))
    gap = np.where(roads.drawn[:, None] & (turned < np.pi / 3), gap, np.inf)
    piece = gap.argmin(axis=2)
    near = (np.take_along_axis(gap, piece[..., None], axis=2)[..., 0] < 10.0) & scenes.present
    row = np.arange(len(scenes))[:, None]
    local = rotate(scenes.position - middle[row, piece], -heading[row, piece])
    turn = wrap_angle(scenes.heading - heading[row, piece])
    size = scenes.agent[..., 1:3] * 5.0
    attributes = np.concatenate([local, turn[..., None], size, scenes.speed[..., None]], axis=-1) / SCALES
    return np.where(near, piece, NO_PIECE), np.where(near[..., None], attributes, 0).astype(np.float32)


class LctgenObjective(Objective):
    """The motion nearest to the log, which mode that is, the prior of actions, and the likelihood of the placement."""

    chunk = 32

    def __init__(self, train: Taught, held_out: Taught, placement: float) -> None:
        super().__init__(train, held_out)
        self.placement = placement

    def mean(self, model: nn.Module, examples: Taught, rows: NDArray[np.integer], device: torch.device, *_: Tensor) -> Tensor:
        """See `Objective`."""
        scenes, bare, code, seen, piece, attributes = examples.tensors(rows, device)
        moved, prior, placed = model(scenes, bare, code)
        loss: Tensor = (
            _motion_loss(scenes, *moved)
            + _prior_loss(prior, code[..., -PARTS:], seen)
            + self.placement * _placement_loss(placed, piece, attributes)
        )
        return loss


class Trainable(nn.Module):
    """The network, run for all of its losses at once (one call, as several processes need it)."""

    def __init__(self, net: LctgenNet) -> None:
        super().__init__()
        self.net = net

    def forward(self, scenes: SceneTensors, bare: SceneTensors, code: Tensor) -> tuple[tuple[Tensor, Tensor], Tensor, Placement]:
        """Knots and logits of modes; the prior's logits (S, A, PARTS, 8); the placement, on the roads of `bare` scenes."""
        net = self.net
        roads, vehicles = net.roads(scenes), net.vehicles(scenes)
        moved = net.moved(scenes, net.decoded(scenes, roads, code, vehicles))
        actions = code[..., -PARTS:]
        prior = torch.stack([net.action_logits(vehicles, actions, part) for part in range(PARTS)], dim=-2)
        roads = net.roads(bare)
        return moved, prior, net.placed(net.decoded(bare, roads, code, None), roads)


_Tensors = tuple[SceneTensors, SceneTensors, Tensor, Tensor, Tensor, Tensor]


def _motion_loss(scenes: SceneTensors, knots: Tensor, logits: Tensor) -> Tensor:
    """Mean displacement [m] of each vehicle's nearest mode, and the cross-entropy of choosing it."""
    each, there = displacement(scenes, knots, futures=2)
    best, which = each.min(dim=-1)
    choice = nn.functional.cross_entropy(logits.flatten(0, 1), which.flatten(), reduction="none").reshape(which.shape)
    return ((best + choice) * there[..., 0]).sum() / there.sum().clamp_min(1)


def _prior_loss(logits: Tensor, actions: Tensor, seen: Tensor) -> Tensor:
    """Cross-entropy of the actions that the log saw."""
    loss = nn.functional.cross_entropy(logits.flatten(0, 2), actions.flatten(), reduction="none").reshape(seen.shape)
    return (loss * seen).sum() / seen.sum().clamp_min(1)


def _placement_loss(placed: Placement, piece: Tensor, attributes: Tensor) -> Tensor:
    """Cross-entropy of the piece and negative log-likelihood of the attributes, of vehicles on a road."""
    near = (piece >= 0).to(placed.piece)
    chosen = nn.functional.cross_entropy(placed.piece.flatten(0, 1), piece.clamp_min(0).flatten(), reduction="none")
    off = (attributes[:, :, None] - placed.mean) / placed.log_scale.exp()
    each = (-0.5 * off**2 - placed.log_scale).sum(-1)
    likelihood = torch.logsumexp(torch.log_softmax(placed.weight, -1) + each, dim=-1)
    return ((chosen.reshape(near.shape) - likelihood) * near).sum() / near.sum().clamp_min(1)
