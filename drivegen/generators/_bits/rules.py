"""The rules by which BITS chooses among sampled plans: nobody is hit, nobody leaves the road."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import depth
from drivegen.generators._bits.raster import Painted, painted_at
from drivegen.generators.shared.closed_loop import Crowd

EVERY = 5
"""Steps between two looks at a plan."""

_FAR = 25.0  # [m] two boxes and the clearance, rounded up


def broken(
    plans: NDArray[np.float32],
    predicted: NDArray[np.float32],
    crowd: Crowd,
    painted: Painted,
    box: NDArray[np.integer],
    clearance: float,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Shares (R, M) of the looks at which each plan overlaps somebody's prediction, and at which its middle is off every lane.

    plans: (R, M, L, 3) x, y, heading on the map, every EVERY steps. predicted: (X, L, 3) the same of all boxes of the crowd.
    clearance: [m] by which boxes must be apart.
    """
    group = crowd.group(box)
    hit, off = np.zeros(plans.shape[:2], np.float32), np.zeros(plans.shape[:2], np.float32)
    _hits(plans, predicted, crowd.start, crowd.there, crowd.state, crowd.size, group, box, clearance, hit)
    _off_road(plans, painted.first, painted.shape, painted.origin, painted.number, crowd.scene[group], off)
    return hit, off


@njit(cache=True)
def _hits(plans, predicted, start, there, state, size, group, box, clearance, hit):  # type: ignore[no-untyped-def]
    looks = plans.shape[2]
    for r in range(len(box)):
        me, own = box[r], _reach(plans[r], state[box[r]]) + _FAR
        touched = np.zeros(plans.shape[1:3], np.bool_)  # by however many
        for other in range(start[group[r]], start[group[r] + 1]):
            if other == me or not there[other] or _overlap(state[me], size[me], state[other], size[other], 0.0):
                continue  # who overlaps already cannot be avoided
            gap = np.hypot(state[other, 0] - state[me, 0], state[other, 1] - state[me, 1])
            if gap > own + _reach(predicted[other : other + 1], state[other]):
                continue
            for m in range(plans.shape[1]):
                for at in range(looks):
                    if _overlap(plans[r, m, at], size[me], predicted[other, at], size[other], clearance):
                        touched[m, at] = True
        hit[r] = touched.sum(axis=1) / looks


@njit(cache=True)
def _reach(ways, state):  # type: ignore[no-untyped-def]
    """How far from where a box is any of its ways (M, L, 3) leads [m]."""
    farthest = 0.0
    for m in range(ways.shape[0]):
        for at in range(ways.shape[1]):
            farthest = max(farthest, np.hypot(ways[m, at, 0] - state[0], ways[m, at, 1] - state[1]))
    return farthest


@njit(cache=True)
def _overlap(pose, size, other, other_size, clearance):  # type: ignore[no-untyped-def]
    dx, dy = other[0] - pose[0], other[1] - pose[1]
    reach = clearance + 0.5 * (np.hypot(size[0], size[1]) + np.hypot(other_size[0], other_size[1]))
    if dx * dx + dy * dy > reach * reach:
        return False
    return depth(dx, dy, pose[2], size[0], size[1], other[2], other_size[0], other_size[1]) > -clearance


@njit(cache=True)
def _off_road(plans, first, shape, origin, number, scene, off):  # type: ignore[no-untyped-def]
    for r in range(len(scene)):
        for m in range(plans.shape[1]):
            for at in range(plans.shape[2]):
                if painted_at(first, shape, origin, number, scene[r], plans[r, m, at, 0], plans[r, m, at, 1]) < 0:
                    off[r, m] += 1.0 / plans.shape[2]
