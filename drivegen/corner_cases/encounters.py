"""Encounters of a target with social vehicles, and the features that the paper keeps of a failure.

An encounter is the closest approach of one social vehicle to the target. Its features are relative speed, relative
heading and what the social vehicle was doing (paper: "relative speed, heading, and driving behavior when collision
happens"). The same function reads them off driven outcomes and off planned motion, so that what was learned from the
first can judge the second.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
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
    gap = np.where(both, box_gap(mover, target_size[..., None, :], social, social_size), np.inf)
    step = np.argmin(gap, axis=-1)
    met = np.asarray(both.any(-1))
    here = step[..., None]

    def at(values: Floats) -> Floats:
        return np.take_along_axis(np.broadcast_to(values, both.shape), here, axis=-1)[..., 0]

    relative = social.velocity - mover.velocity
    closing = np.hypot(at(relative[..., 0]), at(relative[..., 1]))
    turn = wrap_angle(at(social.heading) - at(mover.heading))
    apart = social.position - mover.position
    ahead = at(apart[..., 0] * np.cos(mover.heading) + apart[..., 1] * np.sin(mover.heading))
    return Encounters(
        step=step.astype(np.int16),
        gap=np.where(met, at(gap), np.inf).astype(np.float32),
        speed_bin=np.digitize(closing, SPEED_EDGES).astype(np.uint8),
        direction=_direction(turn),
        behaviour=_behaviour(social, step),
        met=met,
        behind=met & (_direction(turn) == Direction.SAME) & (ahead < -target_size[..., None, 0] / 2),
    )


def box_gap(a: Trajectories, size_a: Floats, b: Trajectories, size_b: Floats) -> Floats:
    """Distance (..., T) [m] between boxes covered by three discs each; never below 0.

    Discs as wide as the box leave out its corners and, of boxes longer than three times their width, stretches between them: good
    enough to rank approaches. Collisions themselves are judged by exact boxes in the simulator.
    """
    radius = (size_a[..., 1] + size_b[..., 1])[..., None] / 2
    nearest = np.inf
    for centre_a in _discs(a, size_a):
        for centre_b in _discs(b, size_b):
            apart = np.hypot(*np.moveaxis(centre_a - centre_b, -1, 0))
            nearest = np.minimum(nearest, apart)
    return np.maximum(nearest - radius, 0.0)


def _discs(motion: Trajectories, size: Floats) -> list[Floats]:
    reach = np.maximum(size[..., 0] - size[..., 1], 0.0)[..., None, None] / 2
    forward = unit(motion.heading)
    return [motion.position + k * reach * forward for k in (-1.0, 0.0, 1.0)]


def _direction(turn: Floats) -> NDArray[np.uint8]:
    """A vehicle that heads to the target's left (positive turn) comes from its right."""
    size = np.abs(turn)
    sideways = np.where(turn > 0, Direction.FROM_RIGHT, Direction.FROM_LEFT)
    return np.where(size < ALONG, Direction.SAME, np.where(size > AGAINST, Direction.OPPOSITE, sideways)).astype(np.uint8)


def _behaviour(social: Trajectories, step: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Behaviour over LOOK_BACK steps before `step` (...): the first that fits of standing, turns, shifts, braking, straight."""
    since = np.maximum(step - LOOK_BACK, 0)

    def at(values: Floats, when: NDArray[np.integer]) -> Floats:
        return np.take_along_axis(values, when[..., None], axis=-1)[..., 0]

    speed = social.speed
    now, before = at(speed, step), at(speed, since)
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
