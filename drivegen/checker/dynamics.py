"""Whether a body on wheels can move like this: acceleration, lateral acceleration, curvature, side slip, honest velocity.

Derivatives are least-squares slopes of the velocity over windows of 11 steps (a Savitzky-Golay filter of first order),
so the noise of tracked logs passes while a planner's jumps do not. Acceleration is split along and across the direction
of travel: a_long = a . v/|v|, a_lat = v/|v| x a, curvature = a_lat / |v|^2. A velocity that the positions do not share is
an error of its own, else a generator could state whatever is legal.
"""

import numpy as np
from numba import njit

from drivegen.checker.limits import ACCELERATION, BRAKING, CURVATURE, LATERAL_ACCELERATION, SIDE_SLIP, SPEED, VELOCITY_ERROR
from drivegen.scenario import DT

HALF = 5
"""Steps to either side of a window's centre."""

STEERING_SPEED = 3.0
"""Curvature is judged above this speed only [m/s]: below it, it is noise divided by zero."""

CRAWL = 1.0
"""Below this speed [m/s] the direction of travel is the vehicle's heading."""

_SQUARES = float(sum(k * k for k in range(-HALF, HALF + 1)))


@njit(cache=True)
def exceed(worst, first, rule, value, limit, step):  # type: ignore[no-untyped-def]
    """Note a severity of `rule` at `step`, and that step if it is the first beyond the limit."""
    if value > worst[rule]:
        worst[rule] = value
    if value > limit[rule] and first[rule] < 0:
        first[rule] = step


@njit(cache=True)
def _window(sums, moments, t, axis):  # type: ignore[no-untyped-def]
    """Mean and slope of one velocity component over the window around step t, from running sums."""
    low, high = t - HALF, t + HALF + 1
    total = sums[high, axis] - sums[low, axis]
    moment = moments[high, axis] - moments[low, axis] - t * total
    return total / (2 * HALF + 1), moment / (_SQUARES * DT)


@njit(cache=True)
def judge(position, heading, velocity, valid, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill the dynamic rules of `worst`, `first` (B, R) for B trajectories (B, T, ...)."""
    steps = valid.shape[1]
    sums, moments = np.zeros((steps + 1, 2)), np.zeros((steps + 1, 2))
    for b in range(valid.shape[0]):
        run = 0  # valid steps up to and including this one, without a gap
        for t in range(steps):
            run = run + 1 if valid[b, t] else 0
            for axis in range(2):
                value = velocity[b, t, axis] if valid[b, t] else 0.0
                sums[t + 1, axis] = sums[t, axis] + value
                moments[t + 1, axis] = moments[t, axis] + t * value
            if run > 2 * HALF:
                _judge_step(position[b], heading[b], sums, moments, t - HALF, limit, worst[b], first[b])


@njit(cache=True)
def _judge_step(position, heading, sums, moments, t, limit, worst, first):  # type: ignore[no-untyped-def]
    vx, ax = _window(sums, moments, t, 0)
    vy, ay = _window(sums, moments, t, 1)
    speed = np.sqrt(vx * vx + vy * vy)
    span = 2 * HALF * DT
    mx, my = (position[t + HALF, 0] - position[t - HALF, 0]) / span, (position[t + HALF, 1] - position[t - HALF, 1]) / span
    exceed(worst, first, VELOCITY_ERROR, np.sqrt((mx - vx) ** 2 + (my - vy) ** 2), limit, t)
    exceed(worst, first, SPEED, speed, limit, t)
    cos, sin = np.cos(heading[t]), np.sin(heading[t])
    ux, uy = (vx / speed, vy / speed) if speed > CRAWL else (cos, sin)
    along, across = ux * ax + uy * ay, abs(ux * ay - uy * ax)
    exceed(worst, first, ACCELERATION, along, limit, t)
    exceed(worst, first, BRAKING, -along, limit, t)
    exceed(worst, first, LATERAL_ACCELERATION, across, limit, t)
    exceed(worst, first, SIDE_SLIP, abs(cos * vy - sin * vx), limit, t)
    if speed > STEERING_SPEED:
        exceed(worst, first, CURVATURE, across / (speed * speed), limit, t)
