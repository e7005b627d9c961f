"""Red lights, stop lines and giving way, at the gates that a trajectory passes.

A vehicle passes a gate when its front comes LINE_MARGIN beyond the line. It may have taken any sibling lane that its
centre then stays near; a rule is broken only if it is broken on all of these. Giving way is measured by post-encroachment
time: from the moment when the vehicle leaves a conflict point to the one when a vehicle with priority reaches it. Ways that
never wait by a sign, or have a light, have priority here, and those that the map puts first (`roads/gates.py`); not judged are
those who turn left at a light.
"""

import numpy as np
from numba import njit

from drivegen.checker.dynamics import exceed
from drivegen.checker.limits import NEVER, RED_GRACE, STOP_SPEED, YIELD_GAP
from drivegen.core.boxes import bounds
from drivegen.core.scenario import DT
from drivegen.roads.gates import HALF_WIDTH

LINE_MARGIN = 1.0
"""Fronts may stand this far beyond a line [m]: drivers do, and positions are noisy."""

STOP_APPROACH = 5.0
"""A stop must happen on this last stretch before the line [m]."""

AMBIGUOUS = 0.4
"""Sibling lanes are told apart by a mean distance greater than this [m]."""

_ASIDE = 10.0  # [m]: who is before the line and no farther beside it than this comes towards it
_FARTHEST_STEP = 8.0  # [m]: 60 m/s, and a car that turns its front towards the line
_POINT_RADIUS = 0.3
_ALIGNED = 0.7


@njit(cache=True)
def _front(position, heading, gate, direction, length):  # type: ignore[no-untyped-def]
    """(distance of the front beyond the gate, offset of the centre from its middle, cosine to its direction)."""
    dx, dy = position[0] - gate[0], position[1] - gate[1]
    cosine = np.cos(heading) * direction[0] + np.sin(heading) * direction[1]
    return dx * direction[0] + dy * direction[1] + 0.5 * length * cosine, abs(direction[0] * dy - direction[1] * dx), cosine


@njit(cache=True)
def _passes(position, heading, valid, length, gate, direction):  # type: ignore[no-untyped-def]
    """The step at which a vehicle that was seen before the gate is beyond it, or -1."""
    behind, t = False, 0
    while t < valid.shape[0]:
        if not valid[t]:
            t += 1
            continue
        along, aside, cosine = _front(position[t], heading[t], gate, direction, length)
        if along >= LINE_MARGIN and behind and aside < HALF_WIDTH and cosine > _ALIGNED:
            return t
        behind = along < LINE_MARGIN and aside < _ASIDE  # who is beyond the line far aside of it may yet come round a bend
        t += 1 + int(min(abs(along - LINE_MARGIN) / _FARTHEST_STEP, valid.shape[0]))  # it can't be on its other side earlier
    return -1


@njit(cache=True)
def _deviation(position, valid, since, line):  # type: ignore[no-untyped-def]
    """Mean distance of the centres from `line` (P, 2), from step `since` to where the line ends."""
    total, count = 0.0, 0
    zero, one = np.float32(0.0), np.float32(1.0)
    for t in range(since, valid.shape[0], 4):
        if not valid[t]:
            continue
        best, at_end = np.float32(np.inf), False
        for i in range(line.shape[0] - 1):
            sx, sy = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
            dx, dy = position[t, 0] - line[i, 0], position[t, 1] - line[i, 1]
            u = (dx * sx + dy * sy) / max(sx * sx + sy * sy, np.float32(1e-9))
            v = min(max(u, zero), one)
            off_x, off_y = dx - v * sx, dy - v * sy
            gap = off_x * off_x + off_y * off_y
            if gap < best:
                best, at_end = gap, i == line.shape[0] - 2 and u >= one
        if at_end:
            break
        total += np.sqrt(best)
        count += 1
    return total / max(count, 1)


@njit(cache=True)
def _slowest(position, heading, velocity, valid, length, passed, gate, direction):  # type: ignore[no-untyped-def]
    """Lowest speed on the last metres before the line, or NEVER if the vehicle was not seen coming that far."""
    slowest = np.inf
    for t in range(passed, -1, -1):
        if not valid[t]:
            break
        along, _, _ = _front(position[t], heading[t], gate, direction, length)
        if along < -STOP_APPROACH:
            return slowest
        slowest = min(slowest, np.sqrt(velocity[t, 0] ** 2 + velocity[t, 1] ** 2))
    return NEVER


@njit(cache=True)
def _covers(position, heading, size, point):  # type: ignore[no-untyped-def]
    dx, dy = point[0] - position[0], point[1] - position[1]
    length, width = 0.5 * size[0] + _POINT_RADIUS, 0.5 * size[1] + _POINT_RADIUS
    if dx * dx + dy * dy > 1.001 * (length * length + width * width):  # most are: no need to turn
        return False
    cos, sin = np.cos(heading), np.sin(heading)
    return abs(cos * dx + sin * dy) <= length and abs(cos * dy - sin * dx) <= width


@njit(cache=True)
def _paces(position, valid):  # type: ignore[no-untyped-def]
    """(B,) no less than each vehicle's fastest step [m], gaps shared out; what cannot be there yet need not be looked at."""
    paces = np.empty(valid.shape[0], np.float32)
    for b in range(valid.shape[0]):
        fastest, last = np.float32(0.0), -1
        for t in range(valid.shape[1]):
            if not valid[b, t]:
                continue
            if last >= 0:
                dx, dy = position[b, t, 0] - position[b, last, 0], position[b, t, 1] - position[b, last, 1]
                gap = t - last
                fastest = max(fastest, (dx * dx + dy * dy) / np.float32(gap * gap))
            last = t
        paces[b] = np.float32(1.001) * np.sqrt(fastest) + np.float32(0.01)
    return paces


@njit(cache=True)
def _stay(position, heading, valid, size, pace, point, since):  # type: ignore[no-untyped-def]
    """(first, last) step from `since` on at which the box covers `point`, or (-1, -1)."""
    begin, end, t = -1, -1, since
    while t < valid.shape[0]:
        if valid[t] and _covers(position[t], heading[t], size, point):
            begin = t if begin < 0 else begin
            end = t
        elif begin >= 0:
            break
        elif valid[t]:
            away = np.sqrt((point[0] - position[t, 0]) ** 2 + (point[1] - position[t, 1]) ** 2) - 0.5 * (size[0] + size[1])
            t += max(int((away - 2.0 * _POINT_RADIUS) / pace), 0)  # it can't be there earlier
        t += 1
    return begin, end


@njit(cache=True)
def _intrusion(a, passed, g, gates, c, motion, size, others, other_size, skip_own, skip):  # type: ignore[no-untyped-def]
    """Minus the smallest post-encroachment time [s] of vehicle a at one conflict point; NEVER if nobody came after it.

    Both have their paces (B,) as a fifth array, `others` also their bounding boxes (B, 4): most never come near the point.
    """
    position, heading, _, valid, pace = motion
    other_position, other_heading, _, other_valid, other_pace, other_boxes = others
    at, direction, _, _, _, _, _, _, _, _, conflicts, towards = gates
    conflict, way = conflicts[c], towards[c]
    begin, end = _stay(position[a], heading[a], valid[a], size[a], pace[a], conflict, passed)
    worst = NEVER
    if begin < 0:
        return worst
    x, y = conflict
    for m in range(other_valid.shape[0]):
        reach = 0.5 * (other_size[m, 0] + other_size[m, 1])
        away = max(other_boxes[m, 0] - x, x - other_boxes[m, 2], other_boxes[m, 1] - y, y - other_boxes[m, 3])
        if away > reach or m == skip or (skip_own and m == a):
            continue
        came, _ = _stay(other_position[m], other_heading[m], other_valid[m], other_size[m], other_pace[m], conflict, 0)
        if came < begin:
            continue
        same_way = np.cos(other_heading[m, came]) * way[0] + np.sin(other_heading[m, came]) * way[1]
        if same_way < _ALIGNED:
            continue
        own_gate = _passes(other_position[m], other_heading[m], other_valid[m], other_size[m, 0], at[g], direction[g])
        if own_gate < 0:  # whoever follows through the same gate has no priority
            worst = max(worst, -(came - end) * DT)
    return worst


@njit(cache=True)
def judge(gates, motion, size, others, other_size, skip_own, skip, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill the rules of priority in `worst`, `first` (B, R).

    gates: position, direction, group, start, end, line, red_for, stop, give_way, conflict_start, conflict, towards.
    motion and others: position (B, T, 2), heading, velocity, valid, boxes `size` (B, 2). With `skip_own` both are the same
    vehicles and nobody has priority over itself; other number `skip` (or -1) is left out.
    """
    position, heading, velocity, valid = motion
    boxes, paces = bounds(position, valid), _paces(position, valid)
    other_boxes, other_paces = (boxes, paces) if skip_own else (bounds(others[0], others[3]), _paces(others[0], others[3]))
    paced = (position, heading, velocity, valid, paces)
    bounded = (others[0], others[1], others[2], others[3], other_paces, other_boxes)
    at, direction, group, _, _, _, _, _, _, _, _, _ = gates
    leaders = np.flatnonzero(group == np.arange(len(group)))
    for b in range(valid.shape[0]):
        reach = np.float32(0.5) * size[b, 0]
        low_x, low_y, high_x, high_y = boxes[b, 0] - reach, boxes[b, 1] - reach, boxes[b, 2] + reach, boxes[b, 3] + reach
        for g in leaders:
            if at[g, 0] < low_x or at[g, 0] > high_x or at[g, 1] < low_y or at[g, 1] > high_y:
                continue
            passed = _passes(position[b], heading[b], valid[b], size[b, 0], at[g], direction[g])
            if passed >= 0:
                _judge_gate(b, g, passed, gates, paced, size, bounded, other_size, skip_own, skip, limit, worst, first)


@njit(cache=True)
def judge_samples(gates, position, heading, velocity, valid, size, skip, limit, worst, first):  # type: ignore[no-untyped-def]
    """The same for K samples (K, N, T) whose N vehicles are each other's traffic; `worst`, `first` (K, N, R)."""
    for k in range(valid.shape[0]):
        motion = (position[k], heading[k], velocity[k], valid[k])
        judge(gates, motion, size, motion, size, True, skip, limit, worst[k], first[k])


@njit(cache=True)
def _judge_gate(b, leader, passed, gates, motion, size, others, other_size, skip_own, skip, limit, worst, first):  # type: ignore[no-untyped-def]
    """The rules of one group of siblings, for a vehicle that passed their line at step `passed`."""
    position, heading, velocity, valid, _ = motion
    at, direction, group, start, end, line, red_for, stop, give_way, conflict_start, _, _ = gates
    siblings = np.flatnonzero(group == leader)
    if not (red_for[siblings, passed].any() or give_way[siblings].any()):
        exceed(worst, first, b, RED_GRACE, 0.0, limit, passed)
        return
    deviation = np.array([_deviation(position[b], valid[b], passed, line[start[g] : end[g]]) for g in siblings])
    red, rolled, intruded = np.inf, np.inf, np.inf
    for g in siblings[deviation <= deviation.min() + AMBIGUOUS]:
        red = min(red, float(red_for[g, passed] * DT))
        slowest = NEVER
        if stop[g]:
            slowest = _slowest(position[b], heading[b], velocity[b], valid[b], size[b, 0], passed, at[leader], direction[leader])
        rolled = min(rolled, slowest)
        intrusion = NEVER
        if give_way[g]:
            for c in range(conflict_start[g], conflict_start[g + 1]):
                depth = _intrusion(b, passed, g, gates, c, motion, size, others, other_size, skip_own, skip)
                intrusion = max(intrusion, depth)
        intruded = min(intruded, intrusion)
    exceed(worst, first, b, RED_GRACE, red, limit, passed)
    exceed(worst, first, b, STOP_SPEED, rolled, limit, passed)
    exceed(worst, first, b, YIELD_GAP, intruded, limit, passed)
