"""What stands in a neighbour's way: boxes on the stretch of its plan that it is about to drive, and what following them takes.

Only pairs that are near are looked at. Sums and products alone are taken of lists of pairs, which round the same wherever a
pair stands in its list: what a row does depends on that row alone.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from drivegen.world.plan import ARC, COS, SIN, X, Y

if TYPE_CHECKING:
    from drivegen.world.reactive import Reaction

AHEAD, EVERY = 50, 2
"""The stretch is that of so many steps of the plan, of which every other one is looked at."""

MARGIN = 15.0
"""Boxes farther than this [m] beyond the stretch are not looked at."""

CLOSE = 0.1
"""Gaps are taken for no less than this [m]."""


@dataclass(frozen=True)
class Traffic:
    """Boxes of R rows: B of them, the M neighbours first, then the target.

    Attributes:
        pose: (R, 5, B) x, y [m], heading [rad], cosine and sine of it. speed: (R, B) [m/s]. size: (R, B, 2) [m].
        present: (R, B) bool.
    """

    pose: Tensor
    speed: Tensor
    size: Tensor
    present: Tensor


def looks_at(traffic: Traffic, reacts: Tensor, late: Tensor) -> Tensor:
    """Pairs (3, K) of row, neighbour, box near ahead of it that it minds.

    Of those who react, (R, M) bool, everybody minds the target and whoever is `late` (R, M); who is late minds all.
    """
    row, box = torch.nonzero(late & traffic.present[:, :-1], as_tuple=True)
    others = late.shape[1]
    every = torch.arange(others, device=late.device).repeat(len(row))
    row, box = row.repeat_interleave(others), box.repeat_interleave(others)
    target = torch.nonzero(reacts & traffic.present[:, :-1], as_tuple=True)
    rows = torch.cat([target[0], row, row])
    neighbour = torch.cat([target[1], box, every])
    minded = torch.cat([torch.full_like(target[1], others), every, box])
    minds = reacts[rows, neighbour] & traffic.present[rows, neighbour] & traffic.present[rows, minded] & (neighbour != minded)
    rows, neighbour, minded = (index[minds] for index in (rows, neighbour, minded))
    boxes = traffic.pose.shape[2]
    flat, first = traffic.pose.view(-1), rows * (traffic.pose.shape[1] * boxes)
    here, there = first + neighbour, first + minded
    dx, dy = flat.take(there) - flat.take(here), flat.take(there + boxes) - flat.take(here + boxes)
    reach = 0.1 * AHEAD * traffic.speed[rows, neighbour] + MARGIN
    ahead = dx * flat.take(here + COS * boxes) + dy * flat.take(here + SIN * boxes) > -traffic.size[rows, neighbour, 0]
    near = ahead & (dx * dx + dy * dy < reach * reach)
    return torch.stack([rows, neighbour, minded])[:, near]


def demands(
    pairs: Tensor, traffic: Traffic, pose: Tensor, valid: Tensor, first: Tensor, last: Tensor, arc: Tensor, law: "Reaction"
) -> Tensor:
    """Accelerations (K,) [m/s2] that following the boxes of `pairs` would take, inf where the box is not in the way.

    `pose` (A, 6, M) and `valid` (A, M) are the tables of plans; `first`, `last` (R, M) rows in them of each neighbour's present
    and of its plan's end; `arc` (R, M) [m] how far each has come.
    """
    row, neighbour, box = pairs
    begin, end = first[row, neighbour], last[row, neighbour]
    steps = torch.arange(0, AHEAD + 1, EVERY, device=begin.device)
    window = torch.minimum(begin[:, None] + steps, end[:, None])
    channels, others = pose.shape[1:]
    flat, at = pose.view(-1), window * (channels * others) + neighbour[:, None]
    x, y, target_cos, target_sin = (traffic.pose[row, channel, box] for channel in (X, Y, COS, SIN))
    dx, dy = x[:, None] - flat.take(at), y[:, None] - flat.take(at + others)
    apart = torch.where(valid[window, neighbour[:, None]], dx * dx + dy * dy, torch.inf)
    nearest = apart.argmin(dim=1, keepdim=True)
    foot, dx, dy = at.gather(1, nearest)[:, 0], dx.gather(1, nearest)[:, 0], dy.gather(1, nearest)[:, 0]
    cos, sin, there = (flat.take(foot + channel * others) for channel in (COS, SIN, ARC))
    along, left = cos * dx + sin * dy, cos * dy - sin * dx
    facing, across = cos * target_cos + sin * target_sin, (cos * target_sin - sin * target_cos).abs()
    half, own = 0.5 * traffic.size[row, box], 0.5 * traffic.size[row, neighbour]
    half_length = half[:, 0] * facing.abs() + half[:, 1] * across
    half_width = half[:, 0] * across + half[:, 1] * facing.abs()
    distance = there - arc[row, neighbour] + along
    gap = distance - half_length - own[:, 0]
    remaining = flat.take(at[:, -1] + ARC * others) - arc[row, neighbour]
    in_the_way = (left.abs() < half_width + own[:, 1]) & (distance > 0) & (gap < remaining + law.min_gap)
    speed = traffic.speed[row, neighbour]
    closing = speed - facing * traffic.speed[row, box]
    comfort = 2 * (law.acceleration * law.comfort) ** 0.5
    desired_gap = law.min_gap + (speed * law.headway + speed * closing / comfort).clamp_min(0.0)
    ratio = desired_gap / gap.clamp_min(CLOSE)
    return torch.where(in_the_way, law.acceleration * (1 - ratio * ratio), torch.inf)
