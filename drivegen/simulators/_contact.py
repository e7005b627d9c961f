"""The first collision of each target, and who hit whom.

Where two boxes first overlap, the point of contact is the middle of the corners that lie in the other box (or of both
centres, where boxes cross like swords). Seen from each box and scaled by its half length and half width it lies in front,
at the rear or at a side. This is the scheme of nuPlan's at-fault collisions, with both partners looked at.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.boxes import depth
from drivegen.geometry import Floats, box_corners, to_vehicle_frame
from drivegen.scenario import Trajectories
from drivegen.simulators._replay import Replay
from drivegen.simulators.base import NO_PARTNER, CollisionKind, DrivingOutcome

STANDING = 0.1
"""Slower than this [m/s] the target stands."""

_FRONT, _SIDE, _REAR = 0, 1, 2


def outcome(motion: Trajectories, others: Replay, count: int) -> DrivingOutcome:
    """What became of the first `count` rows, their motion cut after the collision."""
    kind, step, partner = first_collisions(motion, others)
    after = (step[:, None] >= 0) & (np.arange(motion.steps) > step[:, None])
    ended = Trajectories(motion.position, motion.heading, motion.velocity, motion.valid & ~after)
    unjudged = np.full(count, np.nan, np.float32)
    return DrivingOutcome(kind[:count], step[:count], partner[:count], ended[:count], unjudged)


def first_collisions(motion: Trajectories, others: Replay) -> tuple[NDArray[np.uint8], NDArray[np.int16], NDArray[np.int32]]:
    """kind (S,), step (S,) and partner (S,) of the first overlap of S targets (S, T) with anyone replayed."""
    count = len(motion.valid)
    step, partner = np.full(count, -1, np.int16), np.full(count, NO_PARTNER, np.int32)
    _find(
        motion.position, motion.heading, motion.valid, others.target_size, others.position, others.heading, others.valid,
        others.size, step, partner,
    )  # fmt: skip
    kind = np.zeros(count, np.uint8)
    for s in np.flatnonzero(step >= 0):
        kind[s] = _kind(motion[s], others, int(s), int(step[s]), int(partner[s]) - 1)
    return kind, step, partner


@njit(cache=True)
def _find(position, heading, valid, size, other_position, other_heading, other_valid, other_size, step, partner):  # type: ignore[no-untyped-def]
    """First overlap in time; of several at one step the deepest."""
    for s in range(valid.shape[0]):
        steps = min(valid.shape[1], other_valid.shape[2])
        for m in range(other_valid.shape[1]):
            reach = 0.5 * (
                np.sqrt(size[s, 0] ** 2 + size[s, 1] ** 2) + np.sqrt(other_size[s, m, 0] ** 2 + other_size[s, m, 1] ** 2)
            )
            until = steps if step[s] < 0 else step[s]
            for t in range(until):
                if not (valid[s, t] and other_valid[s, m, t]):
                    continue
                dx, dy = other_position[s, m, t, 0] - position[s, t, 0], other_position[s, m, t, 1] - position[s, t, 1]
                if dx * dx + dy * dy > reach * reach:
                    continue
                a, b = (heading[s, t], size[s, 0], size[s, 1]), (other_heading[s, m, t], other_size[s, m, 0], other_size[s, m, 1])
                if depth(dx, dy, a[0], a[1], a[2], b[0], b[1], b[2]) > 0:
                    step[s], partner[s] = t, m + 1
                    break


def _kind(target: Trajectories, others: Replay, s: int, t: int, m: int) -> CollisionKind:
    if t == 0:
        return CollisionKind.AT_SPAWN
    if target.speed[t] < STANDING:
        return CollisionKind.HIT_STANDING
    own = (target.position[t], target.heading[t], others.target_size[s])
    other = (others.position[s, m, t], others.heading[s, m, t], others.size[s, m])
    contact = _contact(own, other)
    at_own, at_other = _where(contact, own), _where(contact, other)
    if at_own == _FRONT:
        return CollisionKind.FRONT
    if at_own == _REAR:
        return CollisionKind.HIT_FROM_BEHIND
    return CollisionKind.HIT_IN_SIDE if at_other == _FRONT else CollisionKind.SIDE


_Box = tuple[Floats, Floats, Floats]
"""position (2,), heading (), size (2,)."""


def _contact(a: _Box, b: _Box) -> Floats:
    inside = []
    for box, other in ((a, b), (b, a)):
        corners = box_corners(box[0], box[1], box[2][0], box[2][1])
        seen = np.abs(to_vehicle_frame(corners, other[0], other[1]))
        inside.append(corners[(seen <= other[2] / 2).all(axis=-1)])
    points = np.concatenate(inside)
    return points.mean(axis=0) if len(points) else (a[0] + b[0]) / 2


def _where(point: Floats, box: _Box) -> int:
    """Which end or side of a box a point is nearest to, as a share of its half length and half width."""
    x, y = to_vehicle_frame(point[None], box[0], box[1])[0] / (box[2] / 2)
    if abs(x) < abs(y):
        return _SIDE
    return _FRONT if x > 0 else _REAR
