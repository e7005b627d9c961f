"""The first collision of each target, and who hit whom.

Two boxes come to overlap when the last of the four axes that separated them closes: within the step of the collision, the
one for which `gap before / (gap before - gap now)` is largest. That axis is the normal of the contact, and its angle to
each vehicle's heading tells whether a front, a rear or a side was in it, however deep a step of 0.1 s has driven the boxes
into each other.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import depth
from drivegen.core.geometry import Floats, unit
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.roads.leaving import STAYS, Exits, left_from
from drivegen.world.fault import judge
from drivegen.world.neighbours import Boxes
from drivegen.world.outcome import NO_PARTNER, CollisionKind, DrivingOutcome
from drivegen.world.replay import Replay

if TYPE_CHECKING:
    from drivegen.world.world import World

STANDING = 0.1
"""Slower than this [m/s] the target stands."""

_FRONT, _SIDE, _REAR = range(3)

Pose = tuple[Floats, Floats]
"""Position (2,) [m] and heading [rad]."""


def outcome(motion: Trajectories, others: Replay, scenarios: Sequence[Scenario]) -> DrivingOutcome:
    """What became of the targets of `scenarios`, one a row, their motion cut where they leave the map or after the collision."""
    count = len(scenarios)
    left = _leaving(motion[:count], scenarios)
    motion = left_from(motion, np.concatenate([left, np.full(len(motion.valid) - count, STAYS, np.int16)]))
    kind, step, partner = first_collisions(motion, others)
    after = (step[:, None] >= 0) & (np.arange(motion.steps) > step[:, None])
    ended = Trajectories(motion.position, motion.heading, motion.velocity, motion.valid & ~after)
    gone = (left != STAYS) & (step[:count] < 0)
    contact, fault, speed = judge(motion, others, scenarios, step, partner)
    nothing, unknown = np.zeros(count, np.float32), np.full(count, np.nan, np.float32)
    return DrivingOutcome(
        kind[:count],
        step[:count],
        partner[:count],
        gone,
        ended[:count],
        contact,
        fault,
        speed,
        imposed_braking=nothing,
        imposed_loss=nothing,
        red_lights=unknown,
        red_run=unknown,
        off_road=unknown,
    )


def _leaving(motion: Trajectories, scenarios: Sequence[Scenario]) -> NDArray[np.int16]:
    """(S,) when each target leaves its map; scenarios that share a map object share its exits."""
    exits = {id(scenario.map): Exits.of(scenario.map) for scenario in {id(s.map): s for s in scenarios}.values()}
    return np.array(
        [exits[id(s.map)].crossings(motion[i], s.vehicles.size[TARGET, 0]) for i, s in enumerate(scenarios)], np.int16
    )


def first_collisions(motion: Trajectories, others: Replay) -> tuple[NDArray[np.uint8], NDArray[np.int16], NDArray[np.int32]]:
    """kind (S,), step (S,) and partner (S,) of the first overlap of S targets (S, T) with anyone replayed."""
    step, partner = first_overlaps(motion, others)
    kind = np.zeros(len(step), np.uint8)
    for s in np.flatnonzero(step >= 0):
        kind[s] = _kind(motion[s], others, int(s), int(step[s]), int(partner[s]) - 1)
    return kind, step, partner


def first_overlaps(motion: Trajectories, others: Replay) -> tuple[NDArray[np.int16], NDArray[np.int32]]:
    """step (S,), -1 for none, and partner (S,) of the first overlap of S targets (S, T) with anyone."""
    count = len(motion.valid)
    step, partner = np.full(count, -1, np.int16), np.full(count, NO_PARTNER, np.int32)
    _find(
        motion.position, motion.heading, motion.valid, others.target_size, others.position, others.heading, others.valid,
        others.size, step, partner,
    )  # fmt: skip
    return step, partner


@njit(cache=True)
def _find(position, heading, valid, size, other_position, other_heading, other_valid, other_size, step, partner):  # type: ignore[no-untyped-def]
    """First overlap in time; of several at one step that with the lowest number."""
    for s in range(valid.shape[0]):
        for t in range(min(valid.shape[1], other_valid.shape[1])):
            if not valid[s, t]:
                continue
            pose = (position[s, t, 0], position[s, t, 1], heading[s, t])
            m = _overlapped(pose, size[s], other_position[s, t], other_heading[s, t], other_valid[s, t], other_size[s])
            if m >= 0:
                step[s], partner[s] = t, m + 1
                break


@njit(cache=True)
def _overlapped(pose, size, position, heading, valid, other_size):  # type: ignore[no-untyped-def]
    """Lowest number of M boxes that one box overlaps, -1 if none."""
    x, y, own = pose
    length, width = size
    for m in range(valid.shape[0]):
        if not valid[m]:
            continue
        other_length, other_width = other_size[m]
        reach = 0.5 * (np.sqrt(length**2 + width**2) + np.sqrt(other_length**2 + other_width**2))
        dx, dy = position[m, 0] - x, position[m, 1] - y
        if dx * dx + dy * dy > reach * reach:
            continue
        if depth(dx, dy, own, length, width, heading[m], other_length, other_width) > 0:
            return m
    return -1


def touched(world: "World", boxes: Boxes) -> NDArray[np.int64]:
    """Which of the others, who are in `boxes`, each target overlaps: (R,), the lowest number of several, -1 for none."""
    ego, others = world.ego, (boxes.at, boxes.position, boxes.heading, boxes.valid)
    tensors = (ego.position, ego.heading, world.size, *others)
    partner = np.full(len(world.scene), -1, np.int64)
    _touch(*(tensor.cpu().numpy() for tensor in tensors), world.scenes.replay.size, world.scene.cpu().numpy(), partner)
    return partner


@njit(cache=True)
def _touch(position, heading, size, at, other_position, other_heading, other_valid, other_size, scene, partner):  # type: ignore[no-untyped-def]
    for r in range(len(heading)):
        pose = (position[r, 0], position[r, 1], heading[r])
        partner[r] = _overlapped(
            pose, size[r], other_position[at[r]], other_heading[at[r]], other_valid[at[r]], other_size[scene[r]]
        )


def _kind(target: Trajectories, others: Replay, s: int, t: int, m: int) -> CollisionKind:
    if t == 0:
        return CollisionKind.AT_SPAWN
    before = t - 1 if others.valid[s, t - 1, m] else t
    own = [(target.position[u], target.heading[u]) for u in (before, t)]
    other = [(others.position[s, u, m], others.heading[s, u, m]) for u in (before, t)]
    return kind_of(own, other, (others.target_size[s], others.size[s, m]), float(target.speed[t]))


def kind_of(own: Sequence[Pose], other: Sequence[Pose], sizes: tuple[Floats, Floats], speed: float) -> CollisionKind:
    """Who hit whom, by the poses of target and other before the step and after it, their sizes (2,) and the target's speed."""
    if speed < STANDING:
        return CollisionKind.HIT_STANDING
    then, now = (_gaps(mine, theirs, *sizes) for mine, theirs in zip(own, other, strict=True))
    closing = np.where(then > 0, then / np.maximum(then - now, 1e-9), 0.0)  # when in this step each axis closed
    last = int(np.lexsort((now, closing))[-1])
    (position, heading), (other_position, other_heading) = own[1], other[1]
    normal = _axes(heading, other_heading)[last]
    normal = normal * np.sign(normal @ (other_position - position))
    at_own, at_other = _where(normal, heading), _where(-normal, other_heading)
    if at_own == _FRONT:
        return CollisionKind.FRONT
    if at_own == _REAR:
        return CollisionKind.HIT_FROM_BEHIND
    return CollisionKind.HIT_IN_SIDE if at_other == _FRONT else CollisionKind.SIDE


def _axes(heading_a: Floats, heading_b: Floats) -> Floats:
    """The four box axes (4, 2): forward and left of a, forward and left of b."""
    angles = np.array([heading_a, heading_a + np.pi / 2, heading_b, heading_b + np.pi / 2])
    return unit(angles)


def _gaps(a: tuple[Floats, Floats], b: tuple[Floats, Floats], size_a: Floats, size_b: Floats) -> Floats:
    """Distance (4,) between two boxes along each box axis, negative where they overlap; a, b: position (2,), heading."""
    axes = _axes(a[1], b[1])
    reach = np.abs(axes @ axes[:2].T) @ size_a / 2 + np.abs(axes @ axes[2:].T) @ size_b / 2
    gaps: Floats = np.abs(axes @ (b[0] - a[0])) - reach
    return gaps


def _where(normal: Floats, heading: Floats) -> int:
    """On which face of a box a contact lies whose normal points out of it."""
    forward = float(normal @ unit(heading))
    if abs(forward) < np.cos(np.pi / 4):
        return _SIDE
    return _FRONT if forward > 0 else _REAR
