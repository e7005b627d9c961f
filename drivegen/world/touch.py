"""Who hits whom where the targets of a world's rows touch somebody."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegen.world.contact import Pose, kind_of
from drivegen.world.ego import Ego
from drivegen.world.neighbours import Boxes
from drivegen.world.world import World

Moment: TypeAlias = tuple[Ego, Boxes]
"""Targets and others at one step."""


def kinds(world: World, partner: NDArray[np.integer], before: Moment, now: Moment, begun: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """(R,) CollisionKind of targets that overlap `partner` (R,), -1 for none.

    `before` says nothing of rows that have `begun`, nor where the partner was not there yet; both count as where they are `now`.
    """
    kind = np.zeros(len(partner), np.uint8)
    for r in np.flatnonzero(partner >= 0).tolist():
        m, scene = int(partner[r]), int(world.scene[r])
        appears = begun[r] or not bool(before[1].valid[before[1].at[r], m])
        poses = [(_pose(ego, r), _box(boxes, r, m)) for ego, boxes in (now if appears else before, now)]
        own, other = zip(*poses, strict=True)
        sizes = (world.size[r].cpu().numpy(), world.scenes.replay.size[scene, m])
        kind[r] = kind_of(own, other, sizes, float(world.ego.speed[r]))
    return kind


def _pose(ego: Ego, r: int) -> Pose:
    return ego.position[r].cpu().numpy(), ego.heading[r].cpu().numpy()


def _box(boxes: Boxes, r: int, m: int) -> Pose:
    return boxes.position[boxes.at[r], m].cpu().numpy(), boxes.heading[boxes.at[r], m].cpu().numpy()
