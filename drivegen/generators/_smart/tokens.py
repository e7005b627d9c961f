"""Motion as words: half a second of a vehicle's way, as its own frame at the beginning shows it.

Two ways are as far apart as the corners of a box that goes them, root mean square over the corners and the five steps. The
corners lie symmetrically about the centre, so that this is the distance of (x, y, RADIUS cos turn, RADIUS sin turn): plain
nearest neighbours in 20 numbers.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import rotate, wrap_angle
from drivegen.core.scenario import DT
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.generators.shared.moments import Moments

SPAN = 5
"""Steps of a token."""

RADIUS = 2.6
"""[m] from a car's centre to its corners."""

STILL = 0
"""The token that goes nowhere."""

CODE = 4 * SPAN

_WIDEST, _SHRINK = 2.0, 0.7
_POOL = 20000
"""Logged motions that a vocabulary is chosen from, at most."""

_FASTEST, _FINE = 45.0, 0.25
"""[m/s] Up to the one and as finely as the other, who goes straight on has tokens to be drawn from, though no log is so fast."""

_SLIP = 0.6
"""[m] No slip is farther than this from what was done."""

_WHOLE = 30.0
"""[m] Whoever comes farther than this from one step to the next was not tracked."""


def codes(way: NDArray[np.floating]) -> NDArray[np.float32]:
    """(..., CODE) of ways (..., SPAN, 3) x, y [m], turn [rad] at steps 1..SPAN: Euclidean distances [m] between corners."""
    corners = np.stack([way[..., 0], way[..., 1], RADIUS * np.cos(way[..., 2]), RADIUS * np.sin(way[..., 2])], axis=-1)
    return np.asarray((corners / np.sqrt(SPAN)).reshape(*way.shape[:-2], CODE), np.float32)


def ways(pose: NDArray[np.floating], after: NDArray[np.floating]) -> NDArray[np.float32]:
    """(..., SPAN, 3) of poses `after` (..., SPAN, 3) x, y, heading on the map, in the frame of `pose` (..., 3)."""
    place = rotate(after[..., :2] - pose[..., None, :2], -pose[..., None, 2])
    return np.concatenate([place, wrap_angle(after[..., 2:] - pose[..., None, 2:])], axis=-1).astype(np.float32)


def gone(pose: NDArray[np.floating], way: NDArray[np.floating]) -> NDArray[np.float32]:
    """Poses (..., SPAN, 3) on the map of who goes `way` (..., SPAN, 3) from `pose` (..., 3): the inverse of `ways`."""
    place = pose[..., None, :2] + rotate(way[..., :2], pose[..., None, 2])
    return np.concatenate([place, wrap_angle(way[..., 2:] + pose[..., None, 2:])], axis=-1).astype(np.float32)


def pace(way: NDArray[np.floating]) -> NDArray[np.floating]:
    """[m/s] forward at the end of ways (..., SPAN, 3), over their last two steps; never backward."""
    last = way[..., -1, :2] - way[..., -3, :2]
    return np.asarray(np.maximum(rotate(last, -way[..., -1, 2])[..., 0], 0.0) / (2 * DT))


def logged(tracks: Tracks, box: NDArray[np.integer], step: NDArray[np.integer]) -> NDArray[np.float32]:
    """Poses (..., 3) x, y, heading of boxes at steps, of equal shapes; the last step stands for those beyond."""
    at = np.minimum(step, tracks.valid.shape[1] - 1)
    return np.concatenate([tracks.position[box, at], tracks.heading[box, at, None]], axis=-1)


def motions(tracks: Tracks) -> NDArray[np.float32]:
    """(E, SPAN, 3) what vehicles did within SPAN steps, every SPAN steps, where all of it was seen; _POOL of them, evenly.

    And, after them, what who is faster than all of these would do.
    """
    moments = Moments(tracks, SPAN, SPAN, throughout=True, most=_POOL)
    box, step = moments[np.arange(len(moments))]
    at = step[:, None] + np.arange(1, SPAN + 1)
    way = ways(logged(tracks, box, step), logged(tracks, np.repeat(box[:, None], SPAN, 1), at))
    way = way[np.abs(way[..., :2]).max(axis=(1, 2), initial=0) < _WHOLE]
    beyond = np.arange(pace(way).max(initial=0.0), _FASTEST, _FINE)[:, None]
    faster = np.zeros((len(beyond), SPAN, 3), np.float32)
    faster[..., 0] = beyond * np.arange(1, SPAN + 1) * DT
    return np.concatenate([way, faster])


def disks(way: NDArray[np.float32], count: int, random: np.random.Generator) -> NDArray[np.float32]:
    """A vocabulary (count, SPAN, 3) out of motions (E, SPAN, 3), STILL the first: k-disks (Philion et al., ICLR 2024).

    In random order each motion that lies outside every disk becomes the centre of one; when none is left the disks shrink,
    until there are `count`. So wide disks cover rare motions, and what is left goes where most motions are. Fewer different
    motions than that leave the rest of the vocabulary to stand still, which is never matched.
    """
    chosen = np.zeros((count, SPAN, 3), np.float32)
    code, centre = codes(way), codes(chosen[:1])
    order = random.permutation(len(way))
    gap = np.square(code - centre).sum(axis=1)
    made, radius = 1, _WIDEST
    while made < count and gap.max(initial=0) > 1e-6:
        outside = order[gap[order] > radius**2]
        while made < count and len(outside):
            chosen[made] = way[outside[0]]
            gap = np.minimum(gap, np.square(code - code[outside[0]]).sum(axis=1))
            outside, made = outside[gap[outside] > radius**2], made + 1
        radius *= _SHRINK
    return chosen


@dataclass(frozen=True)
class Vocabulary:
    """Tokens (W, SPAN, 3): ways in the frame in which they begin."""

    way: NDArray[np.float32]

    def distances(self, way: NDArray[np.floating]) -> NDArray[np.float32]:
        """(R, W) squared distances [m2] of ways (R, SPAN, 3) to every token; those that repeat another are infinitely far."""
        code, own = codes(way), codes(self.way)
        between = np.maximum((code**2).sum(1)[:, None] - 2 * code @ own.T + (own**2).sum(1), 0.0)
        spare = (self.way == self.way[STILL]).all(axis=(1, 2))
        spare[STILL] = False
        between[:, spare] = np.inf
        return np.asarray(between)

    def disturbed(self, between: NDArray[np.float32], nearest: int, random: np.random.Generator) -> NDArray[np.intp]:
        """(R,) one of the `nearest` tokens by distances (R, W), each as likely; the nearest of all in place of one beyond _SLIP.

        Who stands goes on standing, and nobody stops who doesn't: a slip is of motion.
        """
        count, rows, best = min(nearest, between.shape[1]), np.arange(len(between)), between.argmin(axis=1)
        near = np.argpartition(between, count - 1, axis=1)[:, :count]
        drawn = near[rows, random.integers(0, count, len(rows))]
        kept = (best == STILL) | (drawn == STILL) | (between[rows, drawn] > _SLIP**2)
        return np.where(kept, best, drawn)
