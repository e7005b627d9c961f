"""Slowing down for bends: speeds along a path that take no bend faster than people do, over the same way in the same time."""

import numpy as np
from numba import njit

from drivegen.core.scenario import DT
from drivegen.planners.shared.paths import Doubles, carried_on

HARD, CALM = 4.0, 3.5
"""Who takes a bend with more than HARD acceleration across [m/s2] for a second takes it with CALM instead."""

WINDOW = 5
"""Steps before and after, over which acceleration across is looked at."""

AROUND = 4
"""[m] A bend is what the path turns by from so far before a place to so far behind it: kinks between lanes are driven through."""

SLOWING, GATHERING, HARDEST = 2.5, 2.0, 6.0
"""How fast it slows down before a bend and gathers speed behind it [m/s2]; so hard it brakes where a bend is too near."""

_HALVINGS, _FITTINGS, _EXACT = 8, 3, 0.02
"""How often the interval of what is made up is halved, speeds and places are fitted to one another, and how right the way is."""


@njit(cache=True)
def ease(line: Doubles, start: float, axle: float, way: float, v: Doubles, gone: Doubles) -> None:
    """Change speeds `v` and ways `gone` (steps + 1,) along `line` from `start` on, for bends that would be taken too fast.

    Both ends stay: what is lost in the bend is made up where it drives anyway. Where that takes more than three times
    the speed nothing changes, and who begins or ends too fast in a bend is too fast there.
    """
    if not _swings(line, start, axle, v, gone):
        return
    most = _squares(line, start, axle, way, v[0], v[-1])
    speeds, ways = v.copy(), gone.copy()
    low, high, total = 0.0, 2.0, 0.0
    for _ in range(_HALVINGS):
        factor = (low + high) / 2
        for _ in range(_FITTINGS):
            total = _fit(most, v, factor, way, speeds, ways)
        low, high = (factor, high) if total < way else (low, factor)
    if abs(total - way) < _EXACT * way:
        v[:], gone[:] = speeds, ways


@njit(cache=True)
def _fit(most: Doubles, v: Doubles, factor: float, way: float, speeds: Doubles, ways: Doubles) -> float:
    """Speeds and ways with `factor` more than `v` in between, up to `most`; returns how far [m] that leads, to be put right."""
    last, total = len(v) - 1, 0.0
    for k in range(last + 1):
        speeds[k] = min(v[k] * (1 + factor * 4 * k * (last - k) / last**2), _limit(most, ways[k]))
        if k > 0:
            total += (speeds[k - 1] + speeds[k]) * DT / 2
            ways[k] = total
    ways *= way / max(total, 1e-9)
    return total


@njit(cache=True)
def _swings(line: Doubles, start: float, axle: float, v: Doubles, gone: Doubles) -> bool:
    """Whether it turns on its path with more than HARD, over windows in time as the legal checker's."""
    tx, ty = np.empty(len(v)), np.empty(len(v))
    for k in range(len(v)):
        tx[k], ty[k] = carried_on(line, start + gone[k], axle)[2:4]
        if k >= 2 * WINDOW:
            a = k - 2 * WINDOW
            turned = abs(np.arctan2(tx[a] * ty[k] - ty[a] * tx[k], tx[a] * tx[k] + ty[a] * ty[k]))
            if turned * v[k - WINDOW] > HARD * 2 * WINDOW * DT:
                return True
    return False


@njit(cache=True)
def _squares(line: Doubles, start: float, axle: float, way: float, first: float, final: float) -> Doubles:
    """Squares of the highest speeds [m2/s2] at every metre of the way."""
    count = int(way) + 2
    most, tangents = np.empty(count), np.empty((count + 2 * AROUND, 2))
    for i in range(len(tangents)):
        tangents[i, 0], tangents[i, 1] = carried_on(line, max(start + i - AROUND, 0.0), axle)[2:4]
    for i in range(count):
        (ax, ay), (bx, by) = tangents[i], tangents[i + 2 * AROUND]
        turned = abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))
        most[i] = CALM * 2 * AROUND / max(turned, 1e-4)
    for i in range(count - 2, -1, -1):
        most[i] = min(most[i], most[i + 1] + 2 * SLOWING)
    for i in range(1, count):
        most[i] = min(most[i], most[i - 1] + 2 * GATHERING)
    for i in range(count):
        most[i] = max(most[i], first * first - 2 * HARDEST * i, final * final - 2 * GATHERING * max(way - i, 0.0))
    return most


@njit(cache=True)
def _limit(most: Doubles, gone: float) -> float:
    i = min(int(gone), len(most) - 2)
    limit: float = np.sqrt(max(most[i] + (gone - i) * (most[i + 1] - most[i]), 0.0))
    return limit
