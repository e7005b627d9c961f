"""What TrafficGen's encoder is told about a vehicle: pieces of lanes and boxes around it, in its own frame."""

from typing import NamedTuple, Self

import numpy as np
import torch
from numba import njit
from numpy.typing import NDArray
from torch import Tensor

from drivegen.generators.shared.closed_loop import Crowd
from drivegen.generators.shared.lanes import NEAR, PACE, REACH, LaneVectors, nearest

BOX_FEATURES = 13
"""Place, velocity, direction, speed, length, width, whether it is planned, whether it is the vehicle itself, and the place once
more on the finer scale of NEAR."""


class Surroundings(NamedTuple):
    """Inputs of the encoder for R vehicles.

    Attributes:
        lanes: (R, V, LANE_FEATURES), boxes: (R, A, BOX_FEATURES) float32; the vehicle itself is the first box.
        lane_there: (R, V), box_there: (R, A) bool.
    """

    lanes: NDArray[np.float32]
    lane_there: NDArray[np.bool_]
    boxes: NDArray[np.float32]
    box_there: NDArray[np.bool_]

    @classmethod
    def of(cls, lanes: LaneVectors, crowd: Crowd, box: NDArray[np.integer], counts: tuple[int, int], look: float) -> Self:
        """Around vehicles `box` (R,) of the crowd.

        `counts` are V and A: the lane pieces nearest to where the vehicle will be in `look` seconds, the boxes nearest to it.
        """
        group = crowd.group(box)
        near, near_there = lanes.around(crowd.state[box], crowd.scene[group], crowd.step[group], counts[0], look)
        boxes, box_there = _boxes(crowd.start, crowd.state, crowd.there, crowd.planned, crowd.size, group, box, counts[1])
        return cls(near, near_there, boxes, box_there)

    def tensors(self) -> tuple[Tensor, ...]:
        """The same as tensors."""
        return tuple(map(torch.from_numpy, self))


@njit(cache=True)
def _boxes(start, state, there, planned, size, group, box, count):  # type: ignore[no-untyped-def]
    """(R, count, BOX_FEATURES) and (R, count), the vehicle itself first."""
    out = np.zeros((len(box), count, BOX_FEATURES), np.float32)
    seen = np.zeros((len(box), count), np.bool_)
    for r in range(len(box)):
        first, last, me = start[group[r]], start[group[r] + 1], box[r]
        x, y, cos, sin = state[me, 0], state[me, 1], np.cos(state[me, 2]), np.sin(state[me, 2])
        distance = np.empty(last - first, np.float32)
        for other in range(first, last):
            gap = np.hypot(state[other, 0] - x, state[other, 1] - y)
            distance[other - first] = gap if there[other] and other != me else np.inf
        _box(out[r, 0], state[me], size[me], x, y, cos, sin)
        out[r, 0, 9], out[r, 0, 10], seen[r, 0] = 1.0, 1.0, True
        k = 1
        for other in nearest(distance, count - 1) + first:
            if distance[other - first] < np.inf:
                _box(out[r, k], state[other], size[other], x, y, cos, sin)
                out[r, k, 9], seen[r, k] = planned[other], True
                k += 1
    return out, seen


@njit(cache=True)
def _box(out, state, size, x, y, cos, sin):  # type: ignore[no-untyped-def]
    dx, dy, vx, vy = state[0] - x, state[1] - y, state[3], state[4]
    out[0], out[1] = (cos * dx + sin * dy) / REACH, (cos * dy - sin * dx) / REACH
    out[2], out[3] = (cos * vx + sin * vy) / PACE, (cos * vy - sin * vx) / PACE
    theirs, other = np.cos(state[2]), np.sin(state[2])
    out[4], out[5] = cos * theirs + sin * other, cos * other - sin * theirs
    out[11], out[12] = np.tanh(out[0] * REACH / (2 * NEAR)), np.tanh(out[1] * REACH / NEAR)
    out[6], out[7], out[8] = np.hypot(vx, vy) / PACE, size[0] / 5, size[1] / 2
