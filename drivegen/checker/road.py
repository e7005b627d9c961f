"""Staying on the road, on the right side of it and within its speed limit, by look-ups in the road's rasters."""

import numpy as np
from numba import njit

from drivegen.checker.limits import NEVER, OFF_ROAD, ONCOMING_LANES, OVER_LIMIT, WRONG_WAY
from drivegen.core.scenario import DT
from drivegen.roads.drivable import CELL, LIMIT_UNIT, MARGIN, SECTORS

STRIDE = 2
"""Every second step is looked at [steps]."""

START_TOLERANCE = 0.3
"""Who starts with a corner farther out than this [m] (parked on a drive, a cropped map) is judged once it is on the road."""

WRONG_WAY_SPEED = 1.0
"""Driving against the lanes counts above this speed [m/s]."""

NOTICED, SLOWING = 10, 0.5
"""Who starts above the speed limit slows down from this step on, by at least so much [m/s2]."""

OVER_THE_LINE = 0.25
"""So far [m] a front corner may be on lanes that lead against the vehicle; the raster lets pass up to 0.6 m more, as it gives a
border to the lanes on both sides."""

_AGAINST = 5
"""More than this many sixteenths of a turn from every lane under the vehicle is the wrong way (about 120 degrees)."""

_AGREEING = np.array(
    [sum(1 << ((sector + turn) % SECTORS) for turn in range(-_AGAINST, _AGAINST + 1)) for sector in range(SECTORS)], np.uint16
)
_STILL = 0.05
"""Less change of position [m] and direction than this needs no new look-up."""
LEAST = np.float32(-1e9)
"""Signed distance [m] where all is road."""

_BLUR = np.float32(0.3)
"""Distances between cells are off by no more than this, nearly always [m]."""
_FARTHEST = np.float32(MARGIN)
"""Nobody is farther off the road than this [m]: beyond it rasters of a part of a map may not know the nearest road."""

_PER_METRE = np.float32(1 / CELL)
_HALF = np.float32(0.5)
_SECTORS_PER_RADIAN = SECTORS / (2 * np.pi)
_LIMIT_UNIT = np.float32(LIMIT_UNIT)
_NEVER = np.float32(NEVER)
_SLOWING = np.float32(SLOWING * DT)


@njit(cache=True, error_model="numpy", inline="always")
def _cell(place, origin):  # type: ignore[no-untyped-def]
    """Column or row of a place [m]. In double precision, so that it hardly matters how much of a map was made a raster."""
    return (np.float64(place) - np.float64(origin)) * _PER_METRE


@njit(cache=True, error_model="numpy", inline="always")
def _outside(field, around, x, y):  # type: ignore[no-untyped-def]
    """Signed distance to the road [m] at column x, row y, between four cells; `around` beyond the raster."""
    if x < 0 or y < 0 or y >= field.shape[0] - 1 or x >= field.shape[1] - 1:  # before it is a whole number: those overflow
        return around
    j, i = int(x), int(y)
    u, v = x - j, y - i
    upper = field[i, j] + u * (field[i, j + 1] - field[i, j])
    lower = field[i + 1, j] + u * (field[i + 1, j + 1] - field[i + 1, j])
    return upper + v * (lower - upper)


@njit(cache=True, error_model="numpy")
def corner_outside(field, around, origin, x, y, cos, sin, length, width):  # type: ignore[no-untyped-def]
    """Signed distance of the outermost corner of a box to the road [m]; exact only where it matters, near the edge."""
    column, row = _cell(x, origin[0]), _cell(y, origin[1])
    centre = _outside(field, around, column, row)
    if centre < -_HALF * np.sqrt(length * length + width * width) - _BLUR:
        return centre
    half = np.float32(0.5 * _PER_METRE)
    ax, ay, bx, by = length * half * cos, length * half * sin, -width * half * sin, width * half * cos
    front = max(
        _outside(field, around, column + ax + bx, row + ay + by), _outside(field, around, column + ax - bx, row + ay - by)
    )
    rear = max(_outside(field, around, column - ax + bx, row - ay + by), _outside(field, around, column - ax - bx, row - ay - by))
    return max(front, rear)


@njit(cache=True, error_model="numpy")
def judge(outside, around, directions, limits, origin, position, heading, direction, velocity, valid, size, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill the road rules of `worst`, `first` (B, R) for B trajectories (B, T, ...) of boxes `size` (B, 2).

    `direction` (B, T, 2) are unit vectors of `heading` (B, T).
    """
    for b in range(valid.shape[0]):
        worst[b, OFF_ROAD], first[b, OFF_ROAD] = _judge_edges(
            outside, around, origin, position[b], direction[b], valid[b], size[b, 0], size[b, 1], limit[OFF_ROAD]
        )
        motion = (position[b], heading[b], direction[b], velocity[b], valid[b])
        # An array of results costs more than the look-ups: both rules of the lanes come back as numbers.
        worst[b, WRONG_WAY], first[b, WRONG_WAY], worst[b, OVER_LIMIT], first[b, OVER_LIMIT] = _judge_lanes(
            directions, limits, origin, motion, limit
        )
        worst[b, ONCOMING_LANES], first[b, ONCOMING_LANES] = _judge_sides(
            directions, origin, motion, size[b, 0], size[b, 1], limit[ONCOMING_LANES]
        )


@njit(cache=True, error_model="numpy")
def _judge_edges(outside, around, origin, position, direction, valid, length, width, limit):  # type: ignore[no-untyped-def]
    """(farthest out for three looks in a row [m], first step beyond `limit` or -1)."""
    worst, first, arrived, began = _NEVER, -1, False, LEAST
    last_x = last_y = last_cos = last_sin = np.float32(np.inf)  # what `now` was found for: most vehicles at rest stay so
    now = before = earlier = LEAST  # how far out: three looks in a row, so five steps with STRIDE 2
    for t in range(0, valid.shape[0], STRIDE):
        if not valid[t]:
            now = before = earlier = LEAST
            last_x = np.float32(np.inf)  # what is seen again is looked up again
            continue
        x, y = position[t, 0], position[t, 1]
        earlier, before = before, now
        cos, sin = direction[t, 0], direction[t, 1]
        if abs(x - last_x) + abs(y - last_y) + abs(cos - last_cos) + abs(sin - last_sin) > _STILL:
            now = corner_outside(outside, around, origin, x, y, cos, sin, length, width)
            last_x, last_y, last_cos, last_sin = x, y, cos, sin
        if began == LEAST:
            began = now
        if not arrived and START_TOLERANCE < now <= began + limit:
            before = LEAST
            continue
        arrived = True
        if earlier > LEAST:
            lasting = min(now, before, earlier, _FARTHEST)
            worst = max(worst, lasting)
            if first < 0 and lasting > limit:
                first = t
    return worst, first


@njit(cache=True, error_model="numpy")
def _judge_lanes(directions, limits, origin, motion, limit):  # type: ignore[no-untyped-def]
    """(longest time against the lanes [s], its first step beyond the limit or -1, most above the speed limit [m/s], its step).

    Who starts faster than is legal may take its time, but has to slow down (NOTICED, SLOWING).
    """
    position, heading, direction, velocity, valid = motion
    against, given = 0, _NEVER
    longest, wrong_first, over, over_first = _NEVER, -1, _NEVER, -1
    for t in range(0, valid.shape[0], STRIDE):
        if not valid[t]:
            against = 0
            continue
        j, i = int(_cell(position[t, 0], origin[0]) + _HALF), int(_cell(position[t, 1], origin[1]) + _HALF)
        if i < 0 or j < 0 or i >= limits.shape[0] or j >= limits.shape[1]:
            against, given = 0, max(given, np.float32(0.0))
            continue
        speed = np.sqrt(velocity[t, 0] * velocity[t, 0] + velocity[t, 1] * velocity[t, 1])
        lanes = directions[i, j]
        wrong = speed > WRONG_WAY_SPEED and lanes != 0
        if wrong:
            sector = int(np.floor(heading[t] * _SECTORS_PER_RADIAN)) % SECTORS
            wrong = lanes & _AGREEING[sector] == 0
            if velocity[t, 0] * direction[t, 0] + velocity[t, 1] * direction[t, 1] < 0:  # it drives backwards
                wrong |= lanes & _AGREEING[(sector + SECTORS // 2) % SECTORS] == 0
        against = against + STRIDE if wrong else 0
        lasting = np.float32(against * DT)
        longest = max(longest, lasting)
        if wrong_first < 0 and lasting > limit[WRONG_WAY]:
            wrong_first = t
        if limits[i, j] > 0:
            excess = speed - np.float32(limits[i, j]) * _LIMIT_UNIT
            given = excess - limit[OVER_LIMIT] if given == _NEVER else given  # at the start alone, not where limits begin
            excess -= max(given - max(_SLOWING * np.float32(t - NOTICED), np.float32(0.0)), np.float32(0.0))
            over = max(over, excess)
            if over_first < 0 and excess > limit[OVER_LIMIT]:
                over_first = t
        given = max(given, np.float32(0.0))
    return longest, wrong_first, over, over_first


@njit(cache=True, error_model="numpy", inline="always")
def _leads_against(directions, agreeing, column, row):  # type: ignore[no-untyped-def]
    """Whether there are lanes at a column and row, and all lead elsewhere than the sectors `agreeing`."""
    j, i = int(column + _HALF), int(row + _HALF)
    if i < 0 or j < 0 or i >= directions.shape[0] or j >= directions.shape[1]:
        return False
    lanes = directions[i, j]
    return lanes != 0 and lanes & agreeing == 0


@njit(cache=True, error_model="numpy")
def _judge_sides(directions, origin, motion, length, width, limit):  # type: ignore[no-untyped-def]
    """(longest time with a front corner on lanes that lead against the vehicle [s], the first step beyond `limit` or -1).

    Who starts there, between cars that are parked on both sides, is judged once it has left them.
    """
    position, heading, direction, velocity, valid = motion
    ahead = length * np.float32(0.5 * _PER_METRE)
    aside = max(width * _HALF - np.float32(OVER_THE_LINE), np.float32(0.0)) * _PER_METRE
    longest, first, looks, began = _NEVER, -1, 0, False
    for t in range(0, valid.shape[0], STRIDE):
        if not valid[t]:
            looks = 0
            continue
        drives = velocity[t, 0] * velocity[t, 0] + velocity[t, 1] * velocity[t, 1] > WRONG_WAY_SPEED**2
        on = drives or not began  # who stands where it began has not left it
        if on:
            agreeing = _AGREEING[int(np.floor(heading[t] * _SECTORS_PER_RADIAN)) % SECTORS]
            cos, sin = direction[t, 0], direction[t, 1]
            column = _cell(position[t, 0], origin[0]) + ahead * cos
            row = _cell(position[t, 1], origin[1]) + ahead * sin
            on = _leads_against(directions, agreeing, column - aside * sin, row + aside * cos) or _leads_against(
                directions, agreeing, column + aside * sin, row - aside * cos
            )
        began |= not on
        looks = looks + STRIDE if on and drives and began else 0
        lasting = np.float32(looks * DT)
        longest = max(longest, lasting)
        if first < 0 and lasting > limit:
            first = t
    return longest, first
