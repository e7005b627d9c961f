"""Whom the targets of a world's rows touch, and who hits whom where they do."""

from typing import TypeAlias

import numpy as np
import torch
from numba import njit
from numpy.typing import NDArray
from torch import Tensor

from drivegen.world.contact import kinds_of, overlapped
from drivegen.world.ego import Ego
from drivegen.world.neighbours import Boxes
from drivegen.world.outcome import CollisionKind
from drivegen.world.world import World

Moment: TypeAlias = tuple[Ego, Boxes]
"""Targets and others at one step."""


def touched(world: World, boxes: Boxes) -> Tensor:
    """Which of the others, who are in `boxes`, each target overlaps: (R,) int64, the lowest number of several, -1 for none.

    On a processor box by box, which ends early; elsewhere all with all at once.
    """
    if world.scene.device.type == "cpu":
        return _one_by_one(world, boxes)
    return all_at_once(world, boxes)


def _one_by_one(world: World, boxes: Boxes) -> Tensor:
    ego, partner = world.ego, torch.full_like(world.scene, -1)
    others = (boxes.at, boxes.position, boxes.heading, boxes.valid, world.scenes.others_size)
    tensors = (ego.position, ego.heading, world.size, *others, world.scene, partner)
    _touch(*(tensor.numpy() for tensor in tensors))
    return partner


@njit(cache=True)
def _touch(position, heading, size, at, other_position, other_heading, other_valid, other_size, scene, partner):  # type: ignore[no-untyped-def]
    for r in range(len(heading)):
        pose = (position[r, 0], position[r, 1], heading[r])
        partner[r] = overlapped(
            pose, size[r], other_position[at[r]], other_heading[at[r]], other_valid[at[r]], other_size[scene[r]]
        )


def all_at_once(world: World, boxes: Boxes) -> Tensor:
    """As `touched`, by tensors alone: boxes are apart iff one of the four box axes separates them (`core/boxes.py`)."""
    ego, at = world.ego, boxes.at
    dx, dy = (boxes.position[at] - ego.position[:, None]).unbind(-1)
    half, others_half = 0.5 * world.size[:, None], 0.5 * world.scenes.others_size[world.scene]
    turned = boxes.heading[at] - ego.heading[:, None]
    cos, sin = turned.cos().abs(), turned.sin().abs()
    overlap = boxes.valid[at]
    for heading, a, b in ((ego.heading[:, None], half, others_half), (boxes.heading[at], others_half, half)):
        forward, left = heading.cos() * dx + heading.sin() * dy, heading.cos() * dy - heading.sin() * dx
        overlap = overlap & (forward.abs() < a[..., 0] + b[..., 0] * cos + b[..., 1] * sin)
        overlap = overlap & (left.abs() < a[..., 1] + b[..., 0] * sin + b[..., 1] * cos)
    return torch.where(overlap.any(1), overlap.to(torch.uint8).argmax(1), -1)


def kinds(world: World, partner: Tensor, before: Moment, now: Moment) -> Tensor:
    """(R,) uint8 CollisionKind of targets that overlap `partner` (R,), -1 for none.

    A partner that was not there `before` appears inside the target: AT_SPAWN.
    """
    kind = torch.zeros_like(partner, dtype=torch.uint8)
    r = torch.nonzero(partner >= 0)[:, 0]
    if not len(r):
        return kind
    m, boxes = partner[r], before[1]
    appears = (~boxes.valid[boxes.at[r], m]).cpu().numpy()
    then, after = _poses(before, r, m), _poses(now, r, m)
    for array, later in zip(then, after, strict=True):
        array[appears] = later[appears]  # it was nowhere
    own, other = ([(poses[i], poses[i + 1]) for poses in (then, after)] for i in (0, 2))
    scene, sizes = world.scene[r], world.scenes.others_size
    told = kinds_of(own, other, (_array(world.size[r]), _array(sizes[scene, m])), _array(world.ego.speed[r]))
    kind[r] = torch.from_numpy(np.where(appears, np.uint8(CollisionKind.AT_SPAWN), told)).to(kind.device)
    return kind


def _poses(moment: Moment, r: Tensor, m: Tensor) -> list[NDArray[np.float32]]:
    """Positions and headings of the targets of rows `r` (C,), then those of others `m` (C,) there."""
    ego, boxes = moment
    at = boxes.at[r]
    return [_array(tensor) for tensor in (ego.position[r], ego.heading[r], boxes.position[at, m], boxes.heading[at, m])]


def _array(tensor: Tensor) -> NDArray[np.float32]:
    return np.asarray(tensor.cpu().numpy())
