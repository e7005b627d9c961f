"""Encounters of a target with social vehicles, and the features that the paper keeps of a failure.

An encounter is the closest approach of one social vehicle to the target. Its features are relative speed, relative
heading and what the social vehicle was doing (paper: "relative speed, heading, and driving behavior when collision
happens"). The same function reads them off driven outcomes and off planned motion, so that what was learned from the
first can judge the second.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, to_vehicle_frame, unit, wrap_angle
from drivegen.core.scenario import DT, Trajectories

LOOK_BACK = 30
"""Steps before the closest approach over which behaviour is judged (3 s)."""

SPEED_EDGES = np.array([3.0, 6.0, 10.0, 15.0])
"""Edges of the relative-speed bins [m/s]."""


ALONG, AGAINST = np.pi / 6, 5 * np.pi / 6
"""Relative headings below the one are the same way, beyond the other [rad] oncoming; between them they cross."""

STANDING = 0.5
"""Who is no faster [m/s] at both ends of LOOK_BACK stands ..."""

TURNED = 0.35
"""... else who changed its heading by more than this [rad], 20 degrees, turns ..."""

SHIFTED = 1.2
"""... else who got farther than this [m] to the side shifts lanes ..."""

SLOWED = 1.0
"""... else who slowed down by more than this on average [m/s2] brakes."""


class Direction(IntEnum):
    """Where the social vehicle comes from, seen from the target, by relative heading."""

    SAME = 0
    FROM_LEFT = 1
    FROM_RIGHT = 2
    OPPOSITE = 3


class Behaviour(IntEnum):
    """What the social vehicle did in the last 3 s before the closest approach."""

    STANDING = 0
    BRAKING = 1
    STRAIGHT = 2
    TURNING_LEFT = 3
    TURNING_RIGHT = 4
    SHIFTING_LEFT = 5
    SHIFTING_RIGHT = 6


@dataclass(frozen=True)
class Encounters:
    """Closest approaches; all arrays share one shape, that of the social vehicles without time.

    Attributes:
        step: int16 step of the closest approach.
        gap: float32 [m] distance between the boxes there (discs along their length; 0 is contact).
        speed_bin: uint8 bin of |v_social - v_target| by SPEED_EDGES.
        direction: uint8 Direction. behaviour: uint8 Behaviour.
        met: bool, both are present at some step.
        behind: bool, the social vehicle comes up from behind then: its own duty, nothing that the target's driver is asked.
    """

    step: NDArray[np.int16]
    gap: NDArray[np.float32]
    speed_bin: NDArray[np.uint8]
    direction: NDArray[np.uint8]
    behaviour: NDArray[np.uint8]
    met: NDArray[np.bool_]
    behind: NDArray[np.bool_]


def encounters(target: Trajectories, target_size: Floats, social: Trajectories, social_size: Floats) -> Encounters:
    """Closest approach of each social vehicle (..., M, T) to its target (..., T).

    Sizes are (..., 3) and (..., M, 3) [m]; leading dimensions broadcast.
    """
    mover = Trajectories(
        target.position[..., None, :, :],
        target.heading[..., None, :],
        target.velocity[..., None, :, :],
        target.valid[..., None, :],
    )
    both = mover.valid & social.valid
    step, gap = _closest(both, mover, target_size[..., None, :], social, social_size)
    met, here = np.asarray(both.any(-1)), step[..., None]

    def at(values: Floats) -> Floats:
        return np.take_along_axis(np.broadcast_to(values, both.shape), here, axis=-1)[..., 0]

    def between(name: str, axis: int) -> Floats:
        return np.asarray(at(getattr(social, name)[..., axis]) - at(getattr(mover, name)[..., axis]))

    closing, heading = np.hypot(between("velocity", 0), between("velocity", 1)), at(mover.heading)
    turn = wrap_angle(at(social.heading) - heading)
    ahead = between("position", 0) * np.cos(heading) + between("position", 1) * np.sin(heading)
    return Encounters(
        step=step.astype(np.int16),
        gap=gap,
        speed_bin=np.digitize(closing, SPEED_EDGES).astype(np.uint8),
        direction=_direction(turn),
        behaviour=_behaviour(social, step),
        met=met,
        behind=met & (_direction(turn) == Direction.SAME) & (ahead < -target_size[..., None, 0] / 2),
    )


def _closest(
    both: NDArray[np.bool_], a: Trajectories, size_a: Floats, b: Trajectories, size_b: Floats
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Step (...) of those in which `both` (..., T) are there when boxes are closest, and their distance then [m], inf for never.

    A box is covered by three discs as wide as it. They leave out its corners and, of boxes longer than three times their width,
    stretches between them: good enough to rank approaches. Collisions themselves are judged by exact boxes in the simulator.
    """
    *shape, steps = both.shape

    def flat(values: Floats, *each: int) -> NDArray[np.float32]:
        return np.ascontiguousarray(np.broadcast_to(values, (*shape, *each)), np.float32).reshape(-1, *each)

    def reach(motion: Trajectories, size: Floats) -> NDArray[np.float32]:
        return flat(unit(motion.heading) * (np.maximum(size[..., 0] - size[..., 1], 0) / 2)[..., None, None], steps, 2)

    places, reaches = [flat(c.position, steps, 2) for c in (a, b)], [reach(a, size_a), reach(b, size_b)]
    step, gap = _least_gap(both.reshape(-1, steps), *places, *reaches, flat((size_a[..., 1] + size_b[..., 1]) / 2))
    return step.reshape(shape), gap.reshape(shape)


@njit(cache=True)
def _least_gap(both, place_a, place_b, reach_a, reach_b, radius):  # type: ignore[no-untyped-def]
    """Step and gap (P,) of P pairs; a box has discs at its place (P, T, 2) and a `reach` (P, T, 2) before and behind it."""
    step, least = np.zeros(len(both), np.int64), np.full(len(both), np.float32(np.inf))
    discs = np.array([-1, 0, 1], np.float32)
    for p in range(len(both)):
        for t in np.flatnonzero(both[p]):
            a, b, along_a, along_b = place_a[p, t], place_b[p, t], reach_a[p, t], reach_b[p, t]
            nearest = np.float32(np.inf)
            for i in discs:
                for j in discs:
                    x = (a[0] + i * along_a[0]) - (b[0] + j * along_b[0])
                    y = (a[1] + i * along_a[1]) - (b[1] + j * along_b[1])
                    nearest = min(nearest, np.hypot(x, y))
            gap = max(nearest - radius[p], np.float32(0))
            if gap < least[p]:
                step[p], least[p] = t, gap
    return step, least


def _direction(turn: Floats) -> NDArray[np.uint8]:
    """A vehicle that heads to the target's left (positive turn) comes from its right."""
    size = np.abs(turn)
    sideways = np.where(turn > 0, Direction.FROM_RIGHT, Direction.FROM_LEFT)
    return np.where(size < ALONG, Direction.SAME, np.where(size > AGAINST, Direction.OPPOSITE, sideways)).astype(np.uint8)


def seen_since(valid: NDArray[np.bool_], step: NDArray[np.integer]) -> NDArray[np.intp]:
    """The step from which on vehicles (..., T) are seen without a gap until `step` (...); LOOK_BACK before it at the earliest."""
    gap = np.maximum.accumulate(np.where(valid, -1, np.arange(valid.shape[-1])), axis=-1)
    behind = np.take_along_axis(gap, step[..., None], axis=-1)[..., 0] + 1
    return np.asarray(np.minimum(np.maximum(behind, step - LOOK_BACK), step))


def _behaviour(social: Trajectories, step: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Behaviour over LOOK_BACK steps before `step` (...), fewer where a track begins: the first that fits of standing, turns,
    shifts, braking, straight.
    """
    since = seen_since(social.valid, step)

    def at(values: Floats, when: NDArray[np.integer]) -> Floats:
        return np.take_along_axis(values, when[..., None], axis=-1)[..., 0]

    now, before = (np.hypot(at(social.velocity[..., 0], when), at(social.velocity[..., 1], when)) for when in (step, since))
    turned = wrap_angle(at(social.heading, step) - at(social.heading, since))
    x, y = social.position[..., 0], social.position[..., 1]
    moved = np.stack([at(x, step) - at(x, since), at(y, step) - at(y, since)], axis=-1)
    shift = to_vehicle_frame(moved[..., None, :], np.zeros_like(moved), at(social.heading, since))[..., 0, 1]
    seconds = np.maximum(step - since, 1) * DT
    signs = [
        (np.maximum(now, before) < STANDING, Behaviour.STANDING),
        (turned > TURNED, Behaviour.TURNING_LEFT),
        (turned < -TURNED, Behaviour.TURNING_RIGHT),
        (shift > SHIFTED, Behaviour.SHIFTING_LEFT),
        (shift < -SHIFTED, Behaviour.SHIFTING_RIGHT),
        ((now - before) / seconds < -SLOWED, Behaviour.BRAKING),
    ]
    return np.select([sign for sign, _ in signs], [np.uint8(b) for _, b in signs], np.uint8(Behaviour.STRAIGHT)).astype(np.uint8)
