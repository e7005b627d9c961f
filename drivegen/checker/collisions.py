"""Collisions of vehicles over all steps: oriented boxes behind a circle test, pair by pair.

At 10 Hz boxes of a car's length do not jump through each other below 45 m/s of relative speed.
"""

import numpy as np
from numba import njit

from drivegen.checker.limits import NEVER
from drivegen.core.boxes import bounds, depth


@njit(cache=True)
def _pair(pos_a, head_a, valid_a, length_a, width_a, pos_b, head_b, valid_b, length_b, width_b, tolerance):  # type: ignore[no-untyped-def]
    """(deepest overlap, first step deeper than `tolerance` or -1) of one pair.

    A pair that overlaps at its first common step is not judged until it has come apart: that is given, not planned.
    """
    reach = 0.5 * (np.sqrt(length_a**2 + width_a**2) + np.sqrt(length_b**2 + width_b**2))
    worst, first, inherited, earlier = NEVER, -1, False, False
    for t in range(valid_a.shape[0]):
        if not (valid_a[t] and valid_b[t]):
            continue
        dx, dy = pos_b[t, 0] - pos_a[t, 0], pos_b[t, 1] - pos_a[t, 1]
        touching = False
        if dx * dx + dy * dy <= reach * reach:
            deep = depth(dx, dy, head_a[t], length_a, width_a, head_b[t], length_b, width_b)
            touching = deep > 0
            if touching and not earlier:
                inherited = True
            if touching and not inherited:
                worst = max(worst, deep)
                if first < 0 and deep > tolerance:
                    first = t
        if not touching:
            inherited = False
        earlier = True
    return worst, first


@njit(cache=True)
def _near(box_a, box_b, margin):  # type: ignore[no-untyped-def]
    """Whether two bounding boxes (low x, low y, high x, high y) come within `margin` of each other."""
    return (
        box_a[0] - margin <= box_b[2]
        and box_b[0] - margin <= box_a[2]
        and box_a[1] - margin <= box_b[3]
        and box_b[1] - margin <= box_a[3]
    )


@njit(cache=True)
def _record(worst, first, b, severity, step):  # type: ignore[no-untyped-def]
    worst[b] = max(worst[b], severity)
    if step >= 0 and (first[b] < 0 or step < first[b]):
        first[b] = step


@njit(cache=True)
def against(pos_a, head_a, valid_a, size_a, pos_b, head_b, valid_b, size_b, tolerance, worst, first):  # type: ignore[no-untyped-def]
    """Every a (A boxes) against every b (B boxes); fills `worst` (A,) and `first` (A,) of a."""
    boxes_a, boxes_b = bounds(pos_a, valid_a), bounds(pos_b, valid_b)
    for a in range(valid_a.shape[0]):
        for b in range(valid_b.shape[0]):
            margin = 0.5 * (size_a[a, 0] + size_a[a, 1] + size_b[b, 0] + size_b[b, 1])
            if _near(boxes_a[a], boxes_b[b], margin):
                severity, step = _pair(
                    pos_a[a], head_a[a], valid_a[a], size_a[a, 0], size_a[a, 1],
                    pos_b[b], head_b[b], valid_b[b], size_b[b, 0], size_b[b, 1], tolerance,
                )  # fmt: skip
                _record(worst, first, a, severity, step)


@njit(cache=True)
def among(position, heading, valid, size, skip, tolerance, worst, first):  # type: ignore[no-untyped-def]
    """Every pair of N vehicles in each of K samples (K, N, T), both partners charged, vehicle `skip` (or -1) left out.

    Fills `worst` and `first` (K, N).
    """
    for k in range(valid.shape[0]):
        boxes = bounds(position[k], valid[k])
        for a in range(valid.shape[1]):
            for b in range(a):
                margin = 0.5 * (size[a, 0] + size[a, 1] + size[b, 0] + size[b, 1])
                if a != skip and b != skip and _near(boxes[a], boxes[b], margin):
                    severity, step = _pair(
                        position[k, a], heading[k, a], valid[k, a], size[a, 0], size[a, 1],
                        position[k, b], heading[k, b], valid[k, b], size[b, 0], size[b, 1], tolerance,
                    )  # fmt: skip
                    _record(worst[k], first[k], a, severity, step)
                    _record(worst[k], first[k], b, severity, step)
