"""TrafficGen's networks: stacked multi-context gating over lane pieces and boxes, and a decoder of motion modes."""

from typing import NamedTuple

import torch
from torch import Tensor, nn

from drivegen.core.scenario import DT
from drivegen.generators._trafficgen.vectors import BOX_FEATURES
from drivegen.generators.shared.lanes import LANE_FEATURES, PACE

KNOT = 5
"""Steps between two knots of a mode: velocity and heading are straight between them."""

DT_KNOT = DT * KNOT
"""[s]."""

LARGEST = 3.0
"""What `squashed` bounds numbers by; it halves this very number."""

ACCELERATION, BRAKING = 3.0, 6.0
"""[m/s2] that no mode exceeds."""

CURVATURE, LATERAL = 0.25, 5.0
"""[1/m] and [m/s2] that no mode exceeds: the tightest turn, and how fast it may be driven."""


class Gates(nn.Module):
    """`layers` context gates (MultiPath++, Varadarajan et al. 2022): s' = MLP(s) * MLP(c), c' = max over the set.

    What a gate gives is added to what it was given and normalised, members and context alike.
    """

    def __init__(self, layers: int, width: int) -> None:
        super().__init__()
        self.member, self.context = (nn.ModuleList(nn.Linear(width, width) for _ in range(layers)) for _ in range(2))
        self.norms, self.context_norms = (nn.ModuleList(nn.LayerNorm(width) for _ in range(layers)) for _ in range(2))

    def forward(self, members: Tensor, context: Tensor, there: Tensor | None) -> tuple[Tensor, Tensor]:
        """Members (R, M, D) and context (R, D) gated; there (R, M) bool with one at least in each row, None for all."""
        for layer in range(len(self.member)):
            gated = self.member[layer](members).relu() * self.context[layer](context)[:, None]
            members = self.norms[layer](members + gated)
            seen = members if there is None else members.masked_fill(~there[..., None], -1e4)
            context = self.context_norms[layer](context + seen.amax(dim=1))
        return members, context


class Modes(NamedTuple):
    """What may happen next, in each vehicle's frame: P modes of Q knots, KNOT steps apart.

    Attributes:
        logit: (R, P). velocity: (R, P, Q, 2) [m/s]. place: (R, P, Q, 2) [m]. turn: (R, P, Q) [rad] from the heading now.
    """

    logit: Tensor
    velocity: Tensor
    place: Tensor
    turn: Tensor


class Encoder(nn.Module):
    """Boxes, then lanes in the context of the boxes."""

    def __init__(self, width: int, layers: int) -> None:
        super().__init__()
        self.box, self.lane = embed(BOX_FEATURES, width), embed(LANE_FEATURES, width)
        self.box_gates, self.lane_gates = Gates(layers, width), Gates(layers, width)

    def forward(self, lanes: Tensor, lane_there: Tensor, boxes: Tensor, box_there: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Codes of the lanes (R, V, D), context of the boxes (R, D), context of the lanes (R, D); the first box leads."""
        box = self.box(squashed(boxes))
        _, of_boxes = self.box_gates(box, box[:, 0], box_there)
        lane, of_lanes = self.lane_gates(self.lane(squashed(lanes)), of_boxes, lane_there)
        return lane, of_boxes, of_lanes


class MotionNet(nn.Module):
    """Encoder, learnt anchors gated by the context of all, and heads for odds and motion of each mode."""

    def __init__(self, width: int, layers: int, modes: int, knots: int) -> None:
        super().__init__()
        self.knots = knots
        self.encoder = Encoder(width, layers)
        self.anchors = nn.Parameter(torch.randn(modes, 2 * width))
        self.gates = Gates(layers, 2 * width)
        self.odds = nn.Sequential(nn.Linear(2 * width, width), nn.ReLU(), nn.Linear(width, 1))
        self.motion = nn.Sequential(nn.Linear(2 * width, 2 * width), nn.ReLU(), nn.Linear(2 * width, 2 * knots))

    def forward(self, lanes: Tensor, lane_there: Tensor, boxes: Tensor, box_there: Tensor) -> Modes:
        """Modes of R vehicles from their `Surroundings`."""
        _, of_boxes, of_lanes = self.encoder(lanes, lane_there, boxes, box_there)
        context = torch.cat([of_boxes, of_lanes], dim=-1)
        code, _ = self.gates(self.anchors.expand(len(context), -1, -1), context, None)
        return Modes(self.odds(code)[..., 0], *driven(boxes[:, 0, 2] * PACE, self.motion(code).unflatten(-1, (self.knots, 2))))


def driven(speed: Tensor, pedals: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Velocities, places and turns at the knots from speeds (R,) and how hard is accelerated and steered (R, P, Q, 2).

    Any numbers give a motion within ACCELERATION, BRAKING, CURVATURE and LATERAL, along the heading.
    """
    now = speed[:, None, None].clamp(min=0.0).expand(*pedals.shape[:2], 1)
    gain = torch.where(pedals[..., 0] > 0, ACCELERATION, BRAKING)
    run = torch.cat([now, now + DT_KNOT * (gain * torch.tanh(pedals[..., 0] / gain)).cumsum(dim=-1)], dim=-1)
    run = run + (run.clamp(min=0.0) - run).detach()  # who stands still learns to go on
    between = (run[..., :-1] + run[..., 1:]) / 2
    tightest = (LATERAL / between.detach().square().clamp(min=1.0)).clamp(max=CURVATURE)
    turn = (DT_KNOT * between * tightest * torch.tanh(pedals[..., 1])).cumsum(dim=-1)
    velocity = run[..., 1:, None] * torch.stack([turn.cos(), turn.sin()], dim=-1)
    before = torch.cat([now[..., None] * torch.tensor([1.0, 0.0], device=run.device), velocity[:, :, :-1]], dim=2)
    place = ((before + velocity) * (DT_KNOT / 2)).cumsum(dim=2)
    return velocity, place, turn


def squashed(numbers: Tensor) -> Tensor:
    """The numbers bounded by LARGEST: who is faster than anybody in the logs should not lead far beyond what was learnt."""
    return numbers / (1 + numbers.abs() / LARGEST)


def embed(features: int, width: int) -> nn.Sequential:
    """An MLP of two layers."""
    return nn.Sequential(nn.Linear(features, width), nn.LayerNorm(width), nn.ReLU(), nn.Linear(width, width))
