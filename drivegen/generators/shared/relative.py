"""What surrounds each vehicle at step 0, in its own frame: pieces of road, other vehicles, people and bicycles.

In a vehicle's own frame a road ahead looks alike wherever it lies and however it runs, so nothing has to be learnt twice
for rotated scenes. Numbers are of the order of one.
"""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from drivegen.core.scenario import VehicleKind
from drivegen.generators.shared.attention import mlp
from drivegen.generators.shared.pieces import FEATURES, POINTS
from drivegen.generators.shared.vectors import AGENT_FEATURES, SceneTensors

REACH = 50.0
"""[m] of one unit of position."""

PACE = 10.0
"""[m/s] of one unit of velocity."""

LOOKS = (0.0, 3.0, 7.0)
"""[s] A piece is as near as it is to where the vehicle is, or will be after one of these times at its speed."""

PIECE_FEATURES = 2 * POINTS + 2 + FEATURES
OTHER_FEATURES = 6 + AGENT_FEATURES
ACTOR_FEATURES = 4 + 2 + len(VehicleKind)


@dataclass(frozen=True)
class Surroundings:
    """Of each of A vehicles of S scenes.

    Attributes:
        piece: (S, A, R, PIECE_FEATURES) points, unit direction, features of its lane; nearest first.
        other: (S, A, A, OTHER_FEATURES) position, velocity, cosine and sine of the heading, features; itself at the origin.
        actor: (S, A, C, ACTOR_FEATURES) position, velocity, size, kind.
        there: (S, A, R + A + C) bool which of all these there are; of itself, there always is one.
    """

    piece: Tensor
    other: Tensor
    actor: Tensor
    there: Tensor


def surroundings(scenes: SceneTensors, pieces: int) -> Surroundings:
    """What surrounds each vehicle, its R = `pieces` nearest pieces of road among it."""
    cos, sin = scenes.heading.cos(), scenes.heading.sin()
    near, drawn = _nearest(scenes, cos, sin, pieces)
    batch = torch.arange(len(scenes), device=near.device)[:, None, None]
    points = _turned(scenes.points[batch, near] - scenes.position[:, :, None, None], cos, sin) / REACH
    along = points[..., -1, :] - points[..., 0, :]
    direction = along / along.norm(dim=-1, keepdim=True).clamp_min(1e-6)
    piece = torch.cat([points.flatten(-2), direction, scenes.piece[batch, near]], dim=-1)

    turn = scenes.heading[:, None, :] - scenes.heading[:, :, None]
    facing = torch.stack([turn.cos(), turn.sin()], dim=-1)
    place = _turned(scenes.position[:, None] - scenes.position[:, :, None], cos, sin) / REACH
    pace = facing * (scenes.speed[:, None, :, None] / PACE)
    count = place.shape[1]
    other = torch.cat([place, pace, facing, scenes.agent[:, None].expand(-1, count, -1, -1)], dim=-1)

    gap = _turned(scenes.actor_position[:, None] - scenes.position[:, :, None], cos, sin) / REACH
    moves = _turned(scenes.actor_velocity[:, None].expand(-1, count, -1, -1), cos, sin) / PACE
    actor = torch.cat([gap, moves, scenes.actor[:, None].expand(-1, count, -1, -1)], dim=-1)

    itself = torch.eye(count, dtype=torch.bool, device=near.device)
    others = scenes.present[:, None, :] | itself
    seen = scenes.seen[:, None].expand(-1, count, -1)
    return Surroundings(piece, other, actor, torch.cat([drawn, others, seen], dim=-1))


class SurroundingsEncoder(nn.Module):
    """One code (width) for each surrounding thing, by a small network for each kind of thing."""

    def __init__(self, width: int) -> None:
        super().__init__()
        sizes = (PIECE_FEATURES, OTHER_FEATURES, ACTOR_FEATURES)
        self.kinds = nn.ModuleList([mlp(n, width, width) for n in sizes])

    def forward(self, seen: Surroundings) -> Tensor:
        """(S, A, R + A + C, width)."""
        return torch.cat([net(x) for net, x in zip(self.kinds, (seen.piece, seen.other, seen.actor), strict=True)], dim=2)


def _nearest(scenes: SceneTensors, cos: Tensor, sin: Tensor, count: int) -> tuple[Tensor, Tensor]:
    """Numbers (S, A, R) of the nearest pieces, and whether they are there."""
    middle = scenes.points.mean(dim=2)[:, None]
    ahead = torch.stack([cos, sin], dim=-1) * scenes.speed[..., None]
    gaps = [((middle - (scenes.position + ahead * look)[:, :, None]) ** 2).sum(-1) for look in LOOKS]
    gap = torch.stack(gaps).amin(0).masked_fill(~scenes.drawn[:, None], torch.inf)
    smallest, near = gap.topk(count, dim=-1, largest=False)
    return near, smallest.isfinite()


def _turned(vectors: Tensor, cos: Tensor, sin: Tensor) -> Tensor:
    """Vectors (S, A, ..., 2) of the scene's frame in each vehicle's."""
    shape = (*cos.shape, *[1] * (vectors.dim() - 3))
    c, s = cos.reshape(shape), sin.reshape(shape)
    x, y = vectors[..., 0], vectors[..., 1]
    return torch.stack([c * x + s * y, c * y - s * x], dim=-1)
