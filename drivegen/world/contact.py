"""The first collision of each target, and who hit whom.

Two boxes come to overlap when the last of the four axes that separated them closes: within the step of the collision, the
one for which `gap before / (gap before - gap now)` is largest. That axis is the normal of the contact, and its angle to
each vehicle's heading tells whether a front, a rear or a side was in it, however deep a step of 0.1 s has driven the boxes
into each other.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import depth
from drivegen.core.geometry import Floats, unit
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.roads.leaving import STAYS, Exits, left_from
from drivegen.world.fault import judge
from drivegen.world.observation import STANDING
from drivegen.world.outcome import NO_PARTNER, CollisionKind, DrivingOutcome
from drivegen.world.replay import Replay

_FRONT, _SIDE, _REAR = range(3)

Poses = tuple[Floats, Floats]
"""Positions (C, 2) [m] and headings (C,) [rad]."""


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
    kind, s = np.zeros(len(step), np.uint8), np.flatnonzero(step >= 0)
    t, m = step[s].astype(np.int64), partner[s] - 1
    there = (t > 0) & others.valid[s, t - 1, m]
    before = np.where(there, t - 1, t)
    own = [(motion.position[s, u], motion.heading[s, u]) for u in (before, t)]
    other = [(others.position[s, u, m], others.heading[s, u, m]) for u in (before, t)]
    met = kinds_of(own, other, (others.target_size[s], others.size[s, m]), motion.speed[s, t])
    kind[s] = np.where(there, met, CollisionKind.AT_SPAWN)
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
            m = overlapped(pose, size[s], other_position[s, t], other_heading[s, t], other_valid[s, t], other_size[s])
            if m >= 0:
                step[s], partner[s] = t, m + 1
                break


@njit(cache=True)
def overlapped(pose, size, position, heading, valid, other_size):  # type: ignore[no-untyped-def]
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


def kinds_of(own: Sequence[Poses], other: Sequence[Poses], sizes: tuple[Floats, Floats], speed: Floats) -> NDArray[np.uint8]:
    """(C,) CollisionKind of C collisions: who hit whom.

    `own` and `other` are the poses of targets and others before the step and after it, `sizes` theirs (C, 2), `speed` (C,) [m/s]
    the targets'.
    """
    then, now = (_gaps(mine, theirs, *sizes) for mine, theirs in zip(own, other, strict=True))
    closing = np.where(then > 0, then / np.maximum(then - now, 1e-9), 0.0)  # when in this step each axis closed
    last = np.lexsort((now, closing))[:, -1]
    (position, heading), (other_position, other_heading) = own[1], other[1]
    normal = _axes(heading, other_heading)[np.arange(len(last)), last]
    normal = normal * np.sign((normal * (other_position - position)).sum(-1, keepdims=True))
    at_own, at_other = _where(normal, heading), _where(-normal, other_heading)
    told = [
        (speed < STANDING, CollisionKind.HIT_STANDING),
        (at_own == _FRONT, CollisionKind.FRONT),
        (at_own == _REAR, CollisionKind.HIT_FROM_BEHIND),
        (at_other == _FRONT, CollisionKind.HIT_IN_SIDE),
    ]
    conditions, kinds = zip(*told, strict=True)
    return np.asarray(np.select(conditions, kinds, CollisionKind.SIDE), np.uint8)


def _axes(heading_a: Floats, heading_b: Floats) -> Floats:
    """The four box axes (C, 4, 2): forward and left of a, forward and left of b."""
    angles = np.stack([heading_a, heading_a + np.pi / 2, heading_b, heading_b + np.pi / 2], axis=-1)
    return unit(angles)


def _gaps(a: Poses, b: Poses, size_a: Floats, size_b: Floats) -> Floats:
    """Distance (C, 4) between two boxes along each box axis, negative where they overlap."""
    axes = _axes(a[1], b[1])
    faces = np.abs(axes @ axes.swapaxes(-1, -2))
    half = 0.5 * np.concatenate([size_a, size_b], axis=-1)
    away = (axes * (b[0] - a[0])[:, None]).sum(-1)
    gaps: Floats = np.abs(away) - (faces * half[:, None]).sum(-1)
    return gaps


def _where(normal: Floats, heading: Floats) -> NDArray[np.int64]:
    """(C,) on which face of a box a contact lies whose normal (C, 2) points out of it."""
    forward = (normal * unit(heading)).sum(-1)
    return np.where(np.abs(forward) < np.cos(np.pi / 4), _SIDE, np.where(forward > 0, _FRONT, _REAR))
