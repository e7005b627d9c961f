"""Staying on the road, on the right side of it and within its speed limit, by look-ups in the road's rasters."""

import numpy as np
from numba import njit

from drivegen.checker.dynamics import exceed
from drivegen.checker.limits import OFF_ROAD, OVER_LIMIT, WRONG_WAY
from drivegen.render.drivable import CELL, LIMIT_UNIT, SECTORS
from drivegen.scenario import DT

OFF_ROAD_STEPS = 5
"""A corner is off the road only if one is in each of this many steps in a row."""

START_TOLERANCE = 0.3
"""A vehicle that starts with a corner farther out than this [m] (parked on a drive, a cropped map) is not judged."""

WRONG_WAY_SPEED = 1.0
"""Driving against the lanes counts above this speed [m/s]."""

_AGAINST = 5
"""More than this many sixteenths of a turn from every lane under the vehicle is the wrong way (about 120 degrees)."""

_STILL = 0.05
_LEAST = np.float32(-1e9)


@njit(cache=True)
def _outside(field, origin, x, y):  # type: ignore[no-untyped-def]
    """Signed distance to the road [m], interpolated between four cells; beyond the raster everything is road."""
    column, row = (x - origin[0]) / CELL, (y - origin[1]) / CELL
    j, i = int(np.floor(column)), int(np.floor(row))
    if i < 0 or j < 0 or i >= field.shape[0] - 1 or j >= field.shape[1] - 1:
        return _LEAST
    u, v = column - j, row - i
    return (1 - v) * ((1 - u) * field[i, j] + u * field[i, j + 1]) + v * ((1 - u) * field[i + 1, j] + u * field[i + 1, j + 1])


@njit(cache=True)
def corner_outside(field, origin, x, y, heading, length, width):  # type: ignore[no-untyped-def]
    """Signed distance of the outermost corner of a box to the road [m]; exact only where it matters, near the edge."""
    centre = _outside(field, origin, x, y)
    if centre < -0.5 * np.sqrt(length * length + width * width) - CELL:
        return centre
    cos, sin = 0.5 * np.cos(heading), 0.5 * np.sin(heading)
    worst = _LEAST
    for along in (-length, length):
        for across in (-width, width):
            worst = max(worst, _outside(field, origin, x + along * cos - across * sin, y + along * sin + across * cos))
    return worst


@njit(cache=True)
def _against_lanes(directions, heading):  # type: ignore[no-untyped-def]
    """Whether `directions`, the bit mask of a cell, holds lanes but none within _AGAINST sectors of `heading`."""
    if directions == 0:
        return False
    sector = int(np.floor(heading / (2 * np.pi) * SECTORS))
    near = 0
    for turn in range(-_AGAINST, _AGAINST + 1):
        near |= (directions >> ((sector + turn) % SECTORS)) & 1
    return near == 0


@njit(cache=True)
def judge(outside, directions, limits, origin, position, heading, velocity, valid, size, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill the road rules of `worst`, `first` (B, R) for B trajectories (B, T, ...) of boxes `size` (B, 2)."""
    for b in range(valid.shape[0]):
        _judge_one(
            outside,
            directions,
            limits,
            origin,
            position[b],
            heading[b],
            velocity[b],
            valid[b],
            size[b],
            limit,
            worst[b],
            first[b],
        )


@njit(cache=True)
def _judge_one(outside, directions, limits, origin, position, heading, velocity, valid, size, limit, worst, first):  # type: ignore[no-untyped-def]
    recent = np.full(OFF_ROAD_STEPS, _LEAST)  # how far out the last steps were
    seen, judged, against = 0, 0, 0
    last_x, last_y, out = np.inf, np.inf, _LEAST
    for t in range(valid.shape[0]):
        if not valid[t]:
            recent[:] = _LEAST
            against = 0
            continue
        x, y = position[t, 0], position[t, 1]
        if abs(x - last_x) + abs(y - last_y) > _STILL:
            out = corner_outside(outside, origin, x, y, heading[t], size[0], size[1])
            last_x, last_y = x, y
        if seen == 0:
            judged = int(out <= START_TOLERANCE)
        recent[seen % OFF_ROAD_STEPS] = out
        seen += 1
        if judged and out > 0:
            exceed(worst, first, OFF_ROAD, recent.min(), limit, t)
        speed = np.sqrt(velocity[t, 0] ** 2 + velocity[t, 1] ** 2)
        i, j = int(np.rint((y - origin[1]) / CELL)), int(np.rint((x - origin[0]) / CELL))
        if i < 0 or j < 0 or i >= outside.shape[0] or j >= outside.shape[1]:
            against = 0
            continue
        against = against + 1 if speed > WRONG_WAY_SPEED and _against_lanes(directions[i, j], heading[t]) else 0
        exceed(worst, first, WRONG_WAY, against * DT, limit, t)
        if limits[i, j] > 0:
            exceed(worst, first, OVER_LIMIT, speed - limits[i, j] * LIMIT_UNIT, limit, t)
