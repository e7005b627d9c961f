"""Post-encroachment time: how long after one vehicle another one is at the same place, coming from another direction.

For each pair of vehicles it is the least time between their visits of places that lie nearer than SAME_PLACE, with headings
that differ by more than CROSSING there; pairs that follow one another have headways instead. Centres are compared, not boxes.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import bounds
from drivegen.core.scenario import DT, Trajectories

SAME_PLACE = 2.0
"""Centres this near are at the same place [m]."""

CROSSING = np.deg2rad(30.0)

LONGEST = 10.0
"""Visits farther apart in time than this are no encounter [s]."""


def post_encroachment(motion: Trajectories, known: NDArray[np.bool_]) -> list[NDArray[np.float32]]:
    """The times [s] of one sample after the other, one for each pair that has one: K arrays, from motion, known (K, N, T)."""
    cos, sin = np.cos(motion.heading), np.sin(motion.heading)
    out = []
    for k in range(len(motion.valid)):
        position, mask = np.ascontiguousarray(motion.position[k]), np.ascontiguousarray(known[k])
        steps = _pairs(position, cos[k], sin[k], mask, bounds(position, mask), paces(position, mask), round(LONGEST / DT))
        out.append((steps * DT).astype(np.float32))
    return out


@njit(cache=True)
def paces(position, known):  # type: ignore[no-untyped-def]
    """(N,) the farthest that a vehicle gets in one step [m], gaps bridged evenly; at least a centimetre."""
    paces = np.full(known.shape[0], 0.01)
    for n in range(known.shape[0]):
        last = -1
        for t in range(known.shape[1]):
            if known[n, t]:
                if last >= 0:
                    moved = np.hypot(position[n, t, 0] - position[n, last, 0], position[n, t, 1] - position[n, last, 1])
                    paces[n] = max(paces[n], moved / (t - last))
                last = t
    return paces


@njit(cache=True)
def _pairs(position, cos, sin, known, box, pace, longest):  # type: ignore[no-untyped-def]
    found = np.empty(known.shape[0] * (known.shape[0] - 1) // 2)
    count = 0
    for a in range(known.shape[0]):
        for b in range(a):
            apart = max(box[a, 0] - box[b, 2], box[b, 0] - box[a, 2], box[a, 1] - box[b, 3], box[b, 1] - box[a, 3])
            if apart < SAME_PLACE:
                steps, _, _ = nearest_visits(position, cos, sin, known, a, b, pace[b], longest)
                if steps <= longest:
                    found[count] = steps
                    count += 1
    return found[:count]


@njit(cache=True)
def nearest_visits(position, cos, sin, known, a, b, pace, longest):  # type: ignore[no-untyped-def]
    """Least number of steps between the visits of a and b, and a's and b's; `longest` + 1 if there is none."""
    least, at_a, at_b = longest + 1, 0, 0
    widest = np.cos(CROSSING)
    for s in range(known.shape[1]):
        if not known[a, s]:
            continue
        t = max(0, s - least + 1)
        while t < min(known.shape[1], s + least):
            if not known[b, t]:
                t += 1
                continue
            dx, dy = position[a, s, 0] - position[b, t, 0], position[a, s, 1] - position[b, t, 1]
            apart = np.sqrt(dx * dx + dy * dy)
            if apart < SAME_PLACE:
                if cos[a, s] * cos[b, t] + sin[a, s] * sin[b, t] < widest and abs(s - t) < least:
                    least, at_a, at_b = abs(s - t), s, t
                t += 1
            else:
                t += max(1, int((apart - SAME_PLACE) / pace))  # b can't be here sooner
    return least, at_a, at_b
