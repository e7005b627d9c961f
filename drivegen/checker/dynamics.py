"""Whether a body on wheels can move like this: acceleration, lateral acceleration, curvature, side slip, honest velocity.

Derivatives are least-squares slopes of the velocity over windows of 11 steps (a Savitzky-Golay filter of first order),
so the noise of tracked logs passes while a planner's jumps do not. Acceleration is split along and across the direction
of travel: a_long = a . v/|v|, a_lat = v/|v| x a, curvature = a_lat / |v|^2. A velocity that the positions do not share is
an error of its own, else a generator could state whatever is legal.
"""

import numpy as np
from numba import njit

from drivegen.checker.limits import (
    ACCELERATION,
    BRAKING,
    CURVATURE,
    LATERAL_ACCELERATION,
    NEVER,
    SIDE_SLIP,
    SPEED,
    VELOCITY_ERROR,
)
from drivegen.scenario import DT

HALF = 5
"""Steps to either side of a window's centre."""

STEERING_SPEED = 3.0
"""Curvature is judged above this speed only [m/s]: below it, it is noise divided by zero."""

CRAWL = 1.0
"""Below this speed [m/s] the direction of travel is the vehicle's heading."""

_MEAN = 1 / (2 * HALF + 1)
_SLOPE = 1 / (sum(k * k for k in range(-HALF, HALF + 1)) * DT)
_SPAN = 1 / (2 * HALF * DT)
_RULES = (SPEED, ACCELERATION, BRAKING, LATERAL_ACCELERATION, VELOCITY_ERROR, CURVATURE, SIDE_SLIP)


@njit(cache=True)
def exceed(worst, first, b, rule, value, limit, step):  # type: ignore[no-untyped-def]
    """Note a severity of `rule` of trajectory b at `step`, and that step if it is the first beyond the limit."""
    if value > worst[b, rule]:
        worst[b, rule] = value
        if value > limit[rule] and first[b, rule] < 0:
            first[b, rule] = step


@njit(cache=True, error_model="numpy")
def judge(position, direction, velocity, valid, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill the dynamic rules of `worst`, `first` (B, R) for B trajectories (B, T, ...); `direction` are unit headings."""
    steps = valid.shape[1]
    sums, moments = np.zeros((2, steps + 1)), np.zeros((2, steps + 1))
    whole = np.zeros(steps, np.bool_)  # whether the window around a step has no gap
    nothing = np.float32(0.0)
    found = np.empty((len(_RULES), steps), np.float32)
    for b in range(valid.shape[0]):
        run, sx, sy, mx, my = 0, 0.0, 0.0, 0.0, 0.0
        for t in range(steps):
            run = run + 1 if valid[b, t] else 0
            whole[max(t - HALF, 0)] = run > 2 * HALF
            vx, vy = (velocity[b, t, 0], velocity[b, t, 1]) if valid[b, t] else (nothing, nothing)
            sx, sy, mx, my = sx + vx, sy + vy, mx + t * vx, my + t * vy
            sums[0, t + 1], sums[1, t + 1], moments[0, t + 1], moments[1, t + 1] = sx, sy, mx, my
        _severities(position[b], direction[b], sums[0], sums[1], moments[0], moments[1], found)
        for i, rule in enumerate(_RULES):
            highest = np.float32(NEVER)
            for t in range(HALF, steps - HALF):
                highest = max(highest, found[i, t] if whole[t] else highest)
            worst[b, rule] = highest
            if highest > limit[rule]:
                first[b, rule] = np.argmax((found[i] > limit[rule]) & whole)


@njit(cache=True, error_model="numpy")
def _severities(position, direction, sum_x, sum_y, moment_x, moment_y, found):  # type: ignore[no-untyped-def]
    """Fill `found` (7, T) in the order of _RULES. No branches, so that the compiler makes vector instructions of it."""
    for t in range(HALF, position.shape[0] - HALF):
        low, high = t - HALF, t + HALF + 1
        total_x, total_y = sum_x[high] - sum_x[low], sum_y[high] - sum_y[low]
        vx, vy = total_x * _MEAN, total_y * _MEAN
        ax = (moment_x[high] - moment_x[low] - t * total_x) * _SLOPE
        ay = (moment_y[high] - moment_y[low] - t * total_y) * _SLOPE
        error_x = (position[t + HALF, 0] - position[t - HALF, 0]) * _SPAN - vx
        error_y = (position[t + HALF, 1] - position[t - HALF, 1]) * _SPAN - vy
        speed = np.sqrt(vx * vx + vy * vy)
        inverse = 1 / max(speed, CRAWL)
        ux = vx * inverse if speed > CRAWL else direction[t, 0]
        uy = vy * inverse if speed > CRAWL else direction[t, 1]
        along, across = ux * ax + uy * ay, abs(ux * ay - uy * ax)
        found[0, t] = speed
        found[1, t] = along
        found[2, t] = -along
        found[3, t] = across
        found[4, t] = np.sqrt(error_x * error_x + error_y * error_y)
        found[5, t] = across * inverse * inverse if speed > STEERING_SPEED else 0.0
        found[6, t] = abs(direction[t, 0] * vy - direction[t, 1] * vx)
