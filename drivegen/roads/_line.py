"""The line of a route, computed: pieces of lanes joined, lane changes blended, kinks rounded (kernels of `line.py`).

`lanes` (L,) and `numbers` (L, 3: begin, end, half of the blend [m], 0 for a successor) are the pieces; `points` (P, 2) [m],
`along` (P,) [m] and `half_width` (P, 2) [m] are those of all lanes, of which lane l has start[l] to start[l + 1].
"""

import numpy as np
from numba import njit

SHARPEST = 0.2
"""Kinks are rounded until the line bends no more than this [1/m], a turning circle of 5 m ..."""

MOST_PASSES = 60
"""... or this many smoothing passes are done (a hairpin of two lanes' width needs a sharper bend)."""

LEAST_HALF_WIDTH = 0.3
"""No room beside the line is reported narrower [m]."""


@njit(cache=True)
def abreast(lane, s, other, points, start, along):  # type: ignore[no-untyped-def]
    """Where along lane `other` [m] the point at `s` of `lane` is nearest."""
    i, share = _at(s, lane, -1, start, along)
    x = points[i, 0] + share * (points[i + 1, 0] - points[i, 0])
    y = points[i, 1] + share * (points[i + 1, 1] - points[i, 1])
    best, nearest = 0.0, np.inf
    for k in range(start[other], start[other + 1] - 1):
        ex, ey = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        length = max(np.hypot(ex, ey), 1e-6)
        place = min(max(((x - points[k, 0]) * ex + (y - points[k, 1]) * ey) / length, 0.0), length)
        gap = np.hypot(x - points[k, 0] - place * ex / length, y - points[k, 1] - place * ey / length)
        if gap < nearest:
            best, nearest = along[k] + place, gap
    return best


@njit(cache=True)
def _at(s, lane, hint, start, along):  # type: ignore[no-untyped-def]
    """Segment of the lane under `s` (searched on from `hint`) and the share along it, beyond [0, 1] off the ends."""
    i = max(hint, start[lane])
    last = start[lane + 1] - 2
    while i < last and along[i + 1] <= s:
        i += 1
    return i, (s - along[i]) / max(along[i + 1] - along[i], 1e-6)


@njit(cache=True)
def _blend(x):  # type: ignore[no-untyped-def]
    """Quintic smoothstep from 0 to 1."""
    x = min(max(x, 0.0), 1.0)
    return x * x * x * (x * (6.0 * x - 15.0) + 10.0)


@njit(cache=True)
def _joined(lanes, numbers, points, start, along, half_width, spacing):  # type: ignore[no-untyped-def]
    """Points every `spacing` along the pieces as they are, with jumps at lane changes; heading, piece, room of each."""
    ends = np.cumsum(np.maximum(numbers[:, 1] - numbers[:, 0], 0.0))
    count = int(np.floor(ends[-1] / spacing + 1e-6)) + 1
    line, heading = np.empty((count, 2)), np.empty(count)
    piece, room = np.empty(count, np.int32), np.empty((count, 2))
    p, hint = 0, -1
    for k in range(count):
        u = k * spacing
        while p < len(lanes) - 1 and u >= ends[p]:
            p, hint = p + 1, -1
        s = numbers[p, 1] - (ends[p] - u)
        hint, share = _at(s, lanes[p], hint, start, along)
        step_x, step_y = points[hint + 1, 0] - points[hint, 0], points[hint + 1, 1] - points[hint, 1]
        line[k, 0], line[k, 1] = points[hint, 0] + share * step_x, points[hint, 1] + share * step_y
        heading[k], piece[k] = np.arctan2(step_y, step_x), p
        inside = min(max(share, 0.0), 1.0)
        for side in range(2):
            room[k, side] = half_width[hint, side] + inside * (half_width[hint + 1, side] - half_width[hint, side])
    return line, heading, piece, room, ends


@njit(cache=True)
def _blend_changes(lanes, numbers, ends, line, heading, room, points, start, along, spacing):  # type: ignore[no-untyped-def]
    """Shift the points around each lane change so that the line runs on; in place."""
    for p in range(1, len(lanes)):
        half, at = numbers[p, 2], ends[p - 1]
        if half <= 0:
            continue
        i, share = _at(numbers[p - 1, 1], lanes[p - 1], -1, start, along)
        j, other = _at(numbers[p, 0], lanes[p], -1, start, along)
        ex, ey = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
        jump_x = points[j, 0] + other * (points[j + 1, 0] - points[j, 0]) - points[i, 0] - share * ex
        jump_y = points[j, 1] + other * (points[j + 1, 1] - points[j, 1]) - points[i, 1] - share * ey
        size = max(np.hypot(ex, ey), 1e-6)
        forward, left = (jump_x * ex + jump_y * ey) / size, (jump_y * ex - jump_x * ey) / size
        begin = at - min(half, at)  # a change at the very start is blended after it alone
        for k in range(int(np.ceil(begin / spacing)), min(int((begin + 2 * half) / spacing) + 1, len(line))):
            u = k * spacing
            weight = _blend((u - begin) / (2 * half)) - (1.0 if u >= at else 0.0)
            cos, sin = np.cos(heading[k]), np.sin(heading[k])
            line[k, 0] += weight * (forward * cos - left * sin)
            line[k, 1] += weight * (forward * sin + left * cos)
            room[k, 0] -= weight * left
            room[k, 1] += weight * left


@njit(cache=True)
def _bend(line, k):  # type: ignore[no-untyped-def]
    """Curvature [1/m] at an inner point: angle between its segments over their mean length."""
    ax, ay = line[k, 0] - line[k - 1, 0], line[k, 1] - line[k - 1, 1]
    bx, by = line[k + 1, 0] - line[k, 0], line[k + 1, 1] - line[k, 1]
    angle = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    return abs(angle) / max((np.hypot(ax, ay) + np.hypot(bx, by)) / 2, 1e-3)


@njit(cache=True)
def _still_sharp(line, sharp, bent):  # type: ignore[no-untyped-def]
    """Note in `bent` which points bend too sharply, and in `sharp` those and their neighbours; whether there are any.

    Before, `sharp` are the points that the last pass moved: elsewhere the line bends as it did.
    """
    for k in range(1, len(line) - 1):
        if sharp[k - 1] or sharp[k] or sharp[k + 1]:
            bent[k] = _bend(line, k) > SHARPEST
    sharp[:] = False
    for k in range(1, len(line) - 1):
        if bent[k]:
            sharp[max(k - 2, 0) : k + 3] = True
    return bent.any()


@njit(cache=True)
def _smooth(line):  # type: ignore[no-untyped-def]
    """Two passes over everything, then over what bends too sharply and its neighbours; the ends stay. In place."""
    before = np.empty_like(line)
    sharp, bent = np.ones(len(line), np.bool_), np.zeros(len(line), np.bool_)
    for turn in range(MOST_PASSES):
        if turn >= 2 and not _still_sharp(line, sharp, bent):
            break
        before[:] = line
        for k in range(1, len(line) - 1):
            if sharp[k]:
                for axis in range(2):
                    line[k, axis] = (before[k - 1, axis] + 2 * before[k, axis] + before[k + 1, axis]) / 4


@njit(cache=True)
def joined_line(lanes, numbers, points, start, along, half_width, spacing):  # type: ignore[no-untyped-def]
    """The finished line (P, 2), its heading (P,), the piece under each point (P,), the room beside it (P, 2)."""
    raw, raw_heading, raw_piece, raw_room, ends = _joined(lanes, numbers, points, start, along, half_width, spacing)
    _blend_changes(lanes, numbers, ends, raw, raw_heading, raw_room, points, start, along, spacing)
    _smooth(raw)
    travelled = np.zeros(len(raw))
    for k in range(1, len(raw)):
        travelled[k] = travelled[k - 1] + np.hypot(raw[k, 0] - raw[k - 1, 0], raw[k, 1] - raw[k - 1, 1])
    count = max(int(np.floor(travelled[-1] / spacing + 1e-6)) + 1, 2)
    line, heading = np.empty((count, 2), np.float32), np.empty(count, np.float32)
    piece, room = np.empty(count, np.int32), np.empty((count, 2), np.float32)
    k = 0
    for q in range(count):
        while k < len(raw) - 2 and travelled[k + 1] <= q * spacing:
            k += 1
        share = (q * spacing - travelled[k]) / max(travelled[k + 1] - travelled[k], 1e-6)
        for axis in range(2):
            line[q, axis] = raw[k, axis] + share * (raw[k + 1, axis] - raw[k, axis])
            room[q, axis] = max(raw_room[k, axis] + share * (raw_room[k + 1, axis] - raw_room[k, axis]), LEAST_HALF_WIDTH)
        piece[q] = raw_piece[k]
    for q in range(count):
        a, b = max(q - 1, 0), min(q + 1, count - 1)
        heading[q] = np.arctan2(line[b, 1] - line[a, 1], line[b, 0] - line[a, 0])
        if q > 0:
            heading[q] = heading[q - 1] + (heading[q] - heading[q - 1] + np.pi) % (2 * np.pi) - np.pi
    return line, heading, piece, room


@njit(cache=True)
def layers(lanes, changes, piece, heading, in_junction, speed_limit):  # type: ignore[no-untyped-def]
    """What lies under each point (P,): its lane, the changes until there, how far it has turned in junctions, its limit."""
    lane, shift = np.empty(len(piece), np.int32), np.empty(len(piece), np.int8)
    turned, limit = np.empty(len(piece), np.float32), np.empty(len(piece), np.float32)
    shifts, total = np.cumsum(changes), np.float32(0.0)
    for q in range(len(piece)):
        lane[q], shift[q] = lanes[piece[q]], shifts[piece[q]]
        if q > 0 and in_junction[lane[q]]:
            total += heading[q] - heading[q - 1]
        turned[q], limit[q] = total, speed_limit[lane[q]]
    return lane, shift, turned, limit
