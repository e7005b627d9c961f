"""The others that a vehicle sees at a moment, in its own frame; of the road it sees the nearest pieces (`shared.lanes`)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.generators.shared.lanes import NEAR, PACE, REACH, nearest

OTHER_FEATURES = 12
"""Place, the same on a finer scale, velocity, direction, speed, length, width, whether it is a vehicle that is driven."""

PIECE = 8.0
"""[m] Lanes are cut into straight pieces of about this length."""

LOOK = 1.5
"""[s] The nearest pieces are those around where a vehicle then is at its speed."""


def pose(state: NDArray[np.float32]) -> NDArray[np.float32]:
    """(..., 5) x, y, heading and velocity in x and y of states (..., 4) with speeds."""
    ahead = np.stack([np.cos(state[..., 2]), np.sin(state[..., 2])], axis=-1) * state[..., 3:]
    return np.concatenate([state[..., :3], ahead], axis=-1)


@njit(cache=True)
def others(span, me, state, there, size, driven, count):  # type: ignore[no-untyped-def]
    """The boxes nearest to vehicles `me` (R,), each itself first: (R, T, count, OTHER_FEATURES), whether there, which box.

    Of R vehicles those of the same scene are the boxes `span` (R, 2) from, to; all boxes at T moments: `state` (X, T, 4) x, y,
    heading, speed, `there` (X, T), `size` (X, 2), `driven` (X,).
    """
    steps = state.shape[1]
    out = np.zeros((len(me), steps, count, OTHER_FEATURES), np.float32)
    seen = np.zeros((len(me), steps, count), np.bool_)
    which = np.zeros((len(me), steps, count), np.int64)
    for r in range(len(me)):
        first, last = span[r]
        for t in range(steps):
            x, y, cos, sin = state[me[r], t, 0], state[me[r], t, 1], np.cos(state[me[r], t, 2]), np.sin(state[me[r], t, 2])
            gap = np.full(last - first, np.inf, np.float32)
            for box in range(first, last):
                if there[box, t]:
                    gap[box - first] = np.hypot(state[box, t, 0] - x, state[box, t, 1] - y)
            gap[me[r] - first] = -1.0
            k = 0
            for box in first + nearest(gap, count):
                if gap[box - first] < np.inf:
                    k = k + 1 if box != me[r] else k
                    at = 0 if box == me[r] else k
                    _other(out[r, t, at], state[box, t], size[box], driven[box], x, y, cos, sin)
                    seen[r, t, at], which[r, t, at] = True, box
    return out, seen, which


@njit(cache=True)
def _other(out, state, size, driven, x, y, cos, sin):  # type: ignore[no-untyped-def]
    dx, dy, theirs, other = state[0] - x, state[1] - y, np.cos(state[2]), np.sin(state[2])
    out[0], out[1] = (cos * dx + sin * dy) / REACH, (cos * dy - sin * dx) / REACH
    out[2], out[3] = np.tanh(out[0] * REACH / (2 * NEAR)), np.tanh(out[1] * REACH / NEAR)
    out[4], out[5] = cos * theirs + sin * other, cos * other - sin * theirs
    out[6], out[7], out[8] = out[4] * state[3] / PACE, out[5] * state[3] / PACE, state[3] / PACE
    out[9], out[10], out[11] = size[0] / 5, size[1] / 2, driven
