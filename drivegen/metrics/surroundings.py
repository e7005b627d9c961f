"""What is around a vehicle at each step: how far the nearest box is, the box ahead of it, and whether boxes touch.

Distances and time to collision follow Waymo's Sim Agents metrics (2025). Context actors (people, cyclists) are partners, never
judged themselves. Partners that were not observed at a step are not there.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import separation
from drivegen.core.geometry import Floats, boxes_overlap
from drivegen.core.scenario import Actors, Trajectories
from drivegen.metrics.kinematics import kinematics, within

FARTHEST = 40.0
"""Boxes farther away than this count as this far [m]."""

CORNER_ROUNDING = 0.7
"""Corners of boxes are rounded by this share of half their shorter side, when distances are taken."""

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
        closing: own speed less that of the box ahead [m/s], 0 where none is, NaN where one of both speeds is not known.
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
        position: (K, M, T, 2). cos, sin: (K, M, T) of headings. speed: (K, M, T), NaN where a step beside is
            not known. valid: (K, M, T). size: (M, 2) [m].
    """

    position: NDArray[np.float32]
    cos: NDArray[np.float32]
    sin: NDArray[np.float32]
    speed: NDArray[np.float32]
    valid: NDArray[np.bool_]
    size: NDArray[np.float32]

    @classmethod
    def of(cls, motion: Trajectories, size: Floats, context: Actors) -> "Boxes":
        """From samples (K, N, T), sizes (N, 2 or 3) and context actors; a vehicle counts where it is valid."""
        repeat = np.zeros(len(motion.valid), np.intp)
        people = context.motion[np.newaxis][repeat]
        heading = np.concatenate([motion.heading, people.heading], axis=1)
        return cls(
            np.ascontiguousarray(np.concatenate([motion.position, people.position], axis=1)),
            np.cos(heading),
            np.sin(heading),
            np.concatenate([_known_speed(motion), _known_speed(people)], axis=1),
            np.concatenate([motion.valid, people.valid], axis=1),
            np.ascontiguousarray(np.concatenate([size[:, :2], context.size[:, :2]]), np.float32),
        )


def _known_speed(motion: Trajectories) -> NDArray[np.float32]:
    return np.where(within(motion.valid, 1), kinematics(motion).speed, np.float32(np.nan))


def surroundings(boxes: Boxes, vehicles: int) -> Surroundings:
    """The first `vehicles` boxes among all boxes."""
    samples, count, steps = boxes.cos.shape
    nearest = np.full((samples, count, steps), FARTHEST, np.float32)
    gap, closing = np.full((samples, vehicles, steps), np.inf, np.float32), np.zeros((samples, vehicles, steps), np.float32)
    where, shape = (boxes.position, boxes.cos, boxes.sin), (boxes.valid, boxes.size)
    _find_nearest(*where, *shape, vehicles, nearest)
    _find_leaders(*where, boxes.speed, *shape, gap, closing)
    return Surroundings(nearest[:, :vehicles], gap, closing)


def touching(boxes: Boxes, vehicles: int, scales: NDArray[np.floating]) -> NDArray[np.bool_]:
    """(S, K, N) whether a vehicle ever touches another box, with all boxes scaled by each of `scales` (S,).

    Two boxes that overlap at their first common step are not judged until they have come apart: that is given, not planned.
    """
    hit = np.zeros((len(scales), *boxes.valid.shape[:2]), np.bool_)
    arrays = (boxes.position, boxes.cos, boxes.sin, boxes.valid, boxes.size)
    _touch(*arrays, vehicles, np.ascontiguousarray(scales, np.float64), hit)
    return hit[:, :, :vehicles]


def overlapping_at_first(boxes: Boxes, vehicles: int) -> NDArray[np.bool_]:
    """(N,) whether a vehicle's box overlaps another one at the first frame, as it is given."""
    here = boxes.valid[0, :, 0]
    place, cos, sin = boxes.position[0, :, 0].astype(np.float64), boxes.cos[0, :, 0], boxes.sin[0, :, 0]
    heading, size = np.arctan2(sin, cos), boxes.size
    mine = (place[:vehicles, None], heading[:vehicles, None], size[:vehicles, None])
    touch = boxes_overlap(*mine, place[None], heading[None], size[None]) & here & here[:vehicles, None]
    touch[np.arange(vehicles), np.arange(vehicles)] = False
    return np.asarray(touch.any(axis=1))


def centres_meet(boxes: Boxes, vehicles: int) -> NDArray[np.bool_]:
    """(K, N) av2's `compute_world_collisions` among the vehicles: centres nearer than SAME_CENTRE at some step."""
    hit = np.zeros((len(boxes.position), vehicles), np.bool_)
    for i in range(1, vehicles):
        both = boxes.valid[:, i, None] & boxes.valid[:, :i]
        step = boxes.position[:, i, None] - boxes.position[:, :i]
        near = np.asarray(((step[..., 0] ** 2 + step[..., 1] ** 2 < SAME_CENTRE**2) & both).any(axis=-1))
        hit[:, i] |= near.any(axis=1)
        hit[:, :i] |= near
    return hit


@njit(cache=True)
def _find_nearest(position, cos, sin, valid, size, vehicles, nearest):  # type: ignore[no-untyped-def]
    shrunk = np.float32(CORNER_ROUNDING / 2) * np.minimum(size[:, 0], size[:, 1])
    inner, outer = np.minimum(size[:, 0], size[:, 1]) / 2, np.sqrt(size[:, 0] ** 2 + size[:, 1] ** 2) / 2
    for k in range(cos.shape[0]):
        at_most = nearest[k].copy()
        for a in range(cos.shape[1]):
            for b in range(min(a, vehicles)):
                _bound(position[k, a], position[k, b], valid[k, a], valid[k, b], inner[a] + inner[b], at_most[a], at_most[b])
        at_most[vehicles:] = -np.inf  # nobody asks what is around context actors
        for a in range(cos.shape[1]):
            for b in range(min(a, vehicles)):
                for t in range(cos.shape[2]):
                    if not (valid[k, a, t] and valid[k, b, t]):
                        continue
                    dx, dy = position[k, b, t, 0] - position[k, a, t, 0], position[k, b, t, 1] - position[k, a, t, 1]
                    if np.sqrt(dx * dx + dy * dy) - outer[a] - outer[b] <= max(at_most[a, t], at_most[b, t]):
                        distance = separation(
                            dx, dy, cos[k, a, t], sin[k, a, t], size[a, 0] - 2 * shrunk[a], size[a, 1] - 2 * shrunk[a],
                            cos[k, b, t], sin[k, b, t], size[b, 0] - 2 * shrunk[b], size[b, 1] - 2 * shrunk[b],
                        ) - shrunk[a] - shrunk[b]  # fmt: skip
                        nearest[k, a, t] = min(nearest[k, a, t], distance)
                        nearest[k, b, t] = min(nearest[k, b, t], distance)


@njit(cache=True)
def _bound(position_a, position_b, valid_a, valid_b, inscribed, at_most_a, at_most_b):  # type: ignore[no-untyped-def]
    """Boxes are nearer than the circles that fit into them: an upper bound that spares most exact distances."""
    for t in range(valid_a.shape[0]):
        if valid_a[t] and valid_b[t]:
            dx, dy = position_b[t, 0] - position_a[t, 0], position_b[t, 1] - position_a[t, 1]
            bound = np.sqrt(dx * dx + dy * dy) - inscribed
            at_most_a[t] = min(at_most_a[t], bound)
            at_most_b[t] = min(at_most_b[t], bound)


@njit(cache=True)
def _find_leaders(position, cos, sin, speed, valid, size, gap, closing):  # type: ignore[no-untyped-def]
    for k in range(gap.shape[0]):
        for a in range(gap.shape[1]):
            for b in range(cos.shape[1]):
                for t in range(cos.shape[2]):
                    if a == b or not (valid[k, a, t] and valid[k, b, t]):
                        continue
                    dx, dy = position[k, b, t, 0] - position[k, a, t, 0], position[k, b, t, 1] - position[k, a, t, 1]
                    heading_a, heading_b = (cos[k, a, t], sin[k, a, t]), (cos[k, b, t], sin[k, b, t])
                    ahead = _ahead(dx, dy, heading_a, heading_b, size[a, 0], size[a, 1], size[b, 0], size[b, 1])
                    if ahead < gap[k, a, t]:
                        gap[k, a, t], closing[k, a, t] = ahead, speed[k, a, t] - speed[k, b, t]


@njit(cache=True)
def _ahead(dx, dy, heading_a, heading_b, length_a, width_a, length_b, width_b):  # type: ignore[no-untyped-def]
    """Distance to b's box, if a follows it, else inf; (dx, dy): from a's centre to b's, headings as (cos, sin)."""
    along = heading_a[0] * dx + heading_a[1] * dy
    same = heading_a[0] * heading_b[0] + heading_a[1] * heading_b[1]
    if along <= 0 or same < _WIDEST_ANGLE:
        return np.inf
    cross = abs(heading_a[0] * heading_b[1] - heading_a[1] * heading_b[0])
    ahead = along - (length_a + length_b * same + width_b * cross) / 2
    beside = abs(heading_a[0] * dy - heading_a[1] * dx) - (width_a + length_b * cross + width_b * same) / 2
    if ahead > 0 and beside < 0 and (beside < -_SMALL_OVERLAP or same >= _NARROW_ANGLE):
        return ahead
    return np.inf


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
                    if not (valid[k, a, t] and valid[k, b, t]):
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
