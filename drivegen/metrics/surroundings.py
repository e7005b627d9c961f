"""What is around a vehicle at each step: how far the nearest box is, the box ahead of it, and whether boxes touch.

Distances and time to collision follow Waymo's Sim Agents metrics (2025). Context actors (people, cyclists) are partners, never
judged themselves. Partners that were not observed at a step are not there.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.boxes import separation
from drivegen.geometry import Floats
from drivegen.metrics.kinematics import kinematics
from drivegen.scenario import Actors, Trajectories

FARTHEST = 40.0
"""Boxes farther away than this count as this far [m]."""

CORNER_ROUNDING = 0.7
"""Corners of boxes are rounded by this share of half their shorter side, when distances are taken."""

LONGEST_GAP = 150.0
"""A box ahead is looked for up to this distance [m]."""

SAME_CENTRE = 1.0
"""av2's `compute_world_collisions` calls it a collision when centres come nearer than this [m], whatever the sizes."""

_WIDEST_ANGLE = np.float32(np.cos(np.deg2rad(75.0)))
_NARROW_ANGLE = np.float32(np.cos(np.deg2rad(10.0)))
_SMALL_OVERLAP = 0.5


@dataclass(frozen=True)
class Surroundings:
    """Of K samples of N vehicles over T steps, each (K, N, T) float32.

    Attributes:
        nearest: signed distance to the nearest other box with rounded corners [m], negative where they overlap, FARTHEST at most.
        gap: distance to the box ahead [m], inf where none is.
        closing: own speed less that of the box ahead [m/s], 0 where none is.
    """

    nearest: NDArray[np.float32]
    gap: NDArray[np.float32]
    closing: NDArray[np.float32]

    @property
    def time_to_collision(self) -> NDArray[np.float32]:
        """Gap over closing speed [s], inf where nothing ahead is being closed in on."""
        approaching = self.closing > 0
        return np.where(approaching, self.gap / np.where(approaching, self.closing, 1), np.float32(np.inf)).astype(np.float32)


@dataclass(frozen=True)
class Boxes:
    """All boxes of K samples: first the N vehicles, then the context actors, as the compiled loops need them.

    Attributes:
        position: (K, M, T, 2). cos, sin: (K, M, T) of headings. speed: (K, M, T). valid: (M, T). size: (M, 2) [m].
    """

    position: NDArray[np.float32]
    cos: NDArray[np.float32]
    sin: NDArray[np.float32]
    speed: NDArray[np.float32]
    valid: NDArray[np.bool_]
    size: NDArray[np.float32]

    @classmethod
    def of(cls, motion: Trajectories, known: NDArray[np.bool_], size: Floats, context: Actors) -> "Boxes":
        """From samples (K, N, T), the steps at which each vehicle counts (N, T), sizes (N, 2 or 3) and context actors."""
        repeat = np.zeros(len(motion.valid), np.intp)
        people = context.motion[np.newaxis][repeat]
        heading = np.concatenate([motion.heading, people.heading], axis=1)
        return cls(
            np.ascontiguousarray(np.concatenate([motion.position, people.position], axis=1)),
            np.cos(heading),
            np.sin(heading),
            np.concatenate([kinematics(motion).speed, kinematics(people).speed], axis=1),
            np.concatenate([known, context.motion.valid]),
            np.ascontiguousarray(np.concatenate([size[:, :2], context.size[:, :2]]), np.float32),
        )


def surroundings(boxes: Boxes, vehicles: int) -> Surroundings:
    """The first `vehicles` boxes among all boxes."""
    shape = (len(boxes.position), len(boxes.valid), boxes.valid.shape[1])
    nearest, gap, closing = np.full(shape, FARTHEST, np.float32), np.full(shape, np.inf, np.float32), np.zeros(shape, np.float32)
    arrays = (boxes.position, boxes.cos, boxes.sin, boxes.speed, boxes.valid, boxes.size)
    _look_around(*arrays, vehicles, nearest, gap, closing)
    return Surroundings(nearest[:, :vehicles], gap[:, :vehicles], closing[:, :vehicles])


def touching(boxes: Boxes, vehicles: int, scales: NDArray[np.floating]) -> NDArray[np.bool_]:
    """(S, K, N) whether a vehicle ever touches another box, with all boxes scaled by each of `scales` (S,).

    Two boxes that overlap at their first common step are not judged until they have come apart: that is given, not planned.
    """
    hit = np.zeros((len(scales), len(boxes.position), len(boxes.valid)), np.bool_)
    arrays = (boxes.position, boxes.cos, boxes.sin, boxes.valid, boxes.size)
    _touch(*arrays, vehicles, np.ascontiguousarray(scales, np.float64), hit)
    return hit[:, :, :vehicles]


def centres_meet(boxes: Boxes, vehicles: int) -> NDArray[np.bool_]:
    """(K, N) av2's `compute_world_collisions` among the vehicles: centres nearer than SAME_CENTRE at some step."""
    hit = np.zeros((len(boxes.position), vehicles), np.bool_)
    for i in range(1, vehicles):
        both = boxes.valid[i] & boxes.valid[:i]
        step = boxes.position[:, i, None] - boxes.position[:, :i]
        near = ((step[..., 0] ** 2 + step[..., 1] ** 2 < SAME_CENTRE**2) & both).any(axis=-1)
        hit[:, i] |= near.any(axis=1)
        hit[:, :i] |= near
    return hit


@njit(cache=True)
def _look_around(position, cos, sin, speed, valid, size, vehicles, nearest, gap, closing):  # type: ignore[no-untyped-def]
    samples, count, steps = cos.shape
    shrunk = np.float32(CORNER_ROUNDING / 2) * np.minimum(size[:, 0], size[:, 1])
    radius = np.sqrt(size[:, 0] ** 2 + size[:, 1] ** 2) / 2
    for k in range(samples):
        for a in range(count):
            for b in range(min(a, vehicles)):
                reach = radius[a] + radius[b]
                rounded = shrunk[a] + shrunk[b]
                for t in range(steps):
                    if not (valid[a, t] and valid[b, t]):
                        continue
                    dx, dy = position[k, b, t, 0] - position[k, a, t, 0], position[k, b, t, 1] - position[k, a, t, 1]
                    centres = np.sqrt(dx * dx + dy * dy)
                    if centres - reach < max(nearest[k, a, t], nearest[k, b, t]):
                        distance = (
                            separation(
                                dx, dy, cos[k, a, t], sin[k, a, t], size[a, 0] - 2 * shrunk[a], size[a, 1] - 2 * shrunk[a],
                                cos[k, b, t], sin[k, b, t], size[b, 0] - 2 * shrunk[b], size[b, 1] - 2 * shrunk[b],
                            )
                            - rounded
                        )  # fmt: skip
                        nearest[k, a, t] = min(nearest[k, a, t], distance)
                        nearest[k, b, t] = min(nearest[k, b, t], distance)
                    if centres < LONGEST_GAP:
                        _ahead(k, a, b, t, dx, dy, cos, sin, speed, size, gap, closing)
                        _ahead(k, b, a, t, -dx, -dy, cos, sin, speed, size, gap, closing)


@njit(cache=True)
def _ahead(k, a, b, t, dx, dy, cos, sin, speed, size, gap, closing):  # type: ignore[no-untyped-def]
    """Take b as the box ahead of a, if it is one and nearer than the one so far; (dx, dy): from a's centre to b's."""
    c, s = cos[k, a, t], sin[k, a, t]
    along = c * dx + s * dy
    if along <= 0 or along - size[a, 0] / 2 >= gap[k, a, t] + size[b, 0]:
        return
    same = c * cos[k, b, t] + s * sin[k, b, t]
    if same < _WIDEST_ANGLE:
        return
    cross = abs(c * sin[k, b, t] - s * cos[k, b, t])
    ahead = along - (size[a, 0] + size[b, 0] * same + size[b, 1] * cross) / 2
    beside = abs(c * dy - s * dx) - (size[a, 1] + size[b, 0] * cross + size[b, 1] * same) / 2
    if 0 < ahead < gap[k, a, t] and beside < 0 and (beside < -_SMALL_OVERLAP or same >= _NARROW_ANGLE):
        gap[k, a, t] = ahead
        closing[k, a, t] = speed[k, a, t] - speed[k, b, t]


@njit(cache=True)
def _touch(position, cos, sin, valid, size, vehicles, scales, hit):  # type: ignore[no-untyped-def]
    samples, count, steps = cos.shape
    radius = scales.max() * np.sqrt(size[:, 0] ** 2 + size[:, 1] ** 2) / 2
    inherited = np.zeros(len(scales), np.bool_)
    for k in range(samples):
        for a in range(count):
            for b in range(min(a, vehicles)):
                reach, seen = radius[a] + radius[b], False
                inherited[:] = False
                for t in range(steps):
                    if not (valid[a, t] and valid[b, t]):
                        continue
                    dx, dy = position[k, b, t, 0] - position[k, a, t, 0], position[k, b, t, 1] - position[k, a, t, 1]
                    if dx * dx + dy * dy > reach * reach:
                        inherited[:] = False
                    else:
                        for i in range(len(scales)):
                            scale = scales[i]
                            overlap = separation(
                                dx, dy, cos[k, a, t], sin[k, a, t], scale * size[a, 0], scale * size[a, 1],
                                cos[k, b, t], sin[k, b, t], scale * size[b, 0], scale * size[b, 1],
                            ) < 0  # fmt: skip
                            inherited[i] = overlap and (inherited[i] or not seen)
                            if overlap and not inherited[i]:
                                hit[i, k, a] = hit[i, k, b] = True
                    seen = True
