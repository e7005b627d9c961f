"""Whether a body on wheels can move like this: acceleration, lateral acceleration, curvature, side slip, honest steps.

Derivatives are least-squares slopes of the velocity over windows of 11 steps (a Savitzky-Golay filter of first order),
so the noise of tracked logs passes while a planner's jumps do not. Acceleration is split along and across the direction
of travel: a_long = a . v/|v|, a_lat = v/|v| x a, curvature = a_lat / |v|^2. A velocity that the positions do not share is
an error of its own, else a generator could state whatever is legal.

Only whole windows are looked at: shorter ones would be as noisy as tracked logs are, and limits are read off those. What
happens within one step, a jump, a kick or a turn on the spot, hides in a window, and no window's centre is near the ends, so
every pair of steps is looked at as well.
"""

import numpy as np
from numba import njit

from drivegen.checker.limits import (
    ACCELERATION,
    BRAKING,
    CURVATURE,
    JUMP,
    LATERAL_ACCELERATION,
    NEVER,
    SIDE_SLIP,
    SPEED,
    SPIN,
    VELOCITY_ERROR,
    VELOCITY_STEP,
)
from drivegen.core.scenario import DT

HALF = 5
"""Steps to either side of a window's centre."""

STEERING_SPEED = 3.0
"""Curvature is judged above this speed only [m/s]: below it, it is noise divided by zero."""

CRAWL = 1.0
"""Below this speed [m/s] the direction of travel is the vehicle's heading."""

TIGHTEST = 0.3
"""The sharpest turn that cars can steer, at their middle [1/m]."""

_MEAN = 1 / (2 * HALF + 1)
_SLOPE = 1 / (sum(k * k for k in range(-HALF, HALF + 1)) * DT)
_SPAN = np.float32(1 / (2 * HALF * DT))
_NEVER, _ZERO, _ONE = np.float32(NEVER), np.float32(0.0), np.float32(1.0)
_CRAWL, _STEERING, _TIGHTEST = np.float32(CRAWL), np.float32(STEERING_SPEED), np.float32(TIGHTEST)
_HALF_STEP, _PER_SECOND = np.float32(DT / 2), np.float32(1 / DT)
_RULES = (SPEED, ACCELERATION, BRAKING, LATERAL_ACCELERATION, VELOCITY_ERROR, CURVATURE, SIDE_SLIP)


@njit(cache=True)
def exceed(worst, first, b, rule, value, limit, step):  # type: ignore[no-untyped-def]
    """Note a severity of `rule` of trajectory b at `step`, and that step if it is the first beyond the limit."""
    if value > worst[b, rule]:
        worst[b, rule] = value
    if value > limit[rule] and (first[b, rule] < 0 or step < first[b, rule]):
        first[b, rule] = step


@njit(cache=True, error_model="numpy")
def judge(position, direction, velocity, valid, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill the dynamic rules of `worst`, `first` (B, R) for B trajectories (B, T, ...); `direction` are unit headings."""
    steps = valid.shape[1]
    sums, moments = np.zeros((2, steps + 1)), np.zeros((2, steps + 1))
    whole = np.zeros(steps, np.bool_)  # whether the window around a step has no gap
    for b in range(valid.shape[0]):
        run, sx, sy, mx, my = 0, 0.0, 0.0, 0.0, 0.0
        for t in range(steps):
            run = run + 1 if valid[b, t] else 0
            whole[max(t - HALF, 0)] = run > 2 * HALF
            vx = velocity[b, t, 0] if valid[b, t] else 0.0
            vy = velocity[b, t, 1] if valid[b, t] else 0.0
            sx, sy, mx, my = sx + vx, sy + vy, mx + t * vx, my + t * vy
            sums[0, t + 1], sums[1, t + 1], moments[0, t + 1], moments[1, t + 1] = sx, sy, mx, my
        window = (position[b], direction[b], sums[0], sums[1], moments[0], moments[1])
        highest = _highest(whole, window, HALF, steps - HALF)
        for i, rule in enumerate(_RULES):
            worst[b, rule] = highest[i]
            if highest[i] > limit[rule]:
                t = HALF
                while not _highest(whole, window, t, t + 1)[i] > limit[rule]:
                    t += 1
                first[b, rule] = t
        _judge_steps(position[b], direction[b], velocity[b], valid[b], limit, worst[b], first[b])


@njit(cache=True, error_model="numpy")
def _judge_steps(position, direction, velocity, valid, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill JUMP, VELOCITY_STEP and SPIN of one trajectory's `worst`, `first` (R,)."""
    last = len(valid) - 1
    motion = (position, direction, velocity, valid)
    highest = _highest_steps(motion, 0, last)
    for i, rule in enumerate((JUMP, VELOCITY_STEP, SPIN)):
        worst[rule] = highest[i]
        if highest[i] > limit[rule]:
            t = 0
            while not _highest_steps(motion, t, t + 1)[i] > limit[rule]:
                t += 1
            first[rule] = t + 1


@njit(cache=True, error_model="numpy", fastmath={"nnan", "nsz"})
def _highest_steps(motion, begin, end):  # type: ignore[no-untyped-def]
    """The worst of the steps that begin from `begin` to before `end`.

    Its jump [m], its change of velocity [m/s], and its turn beyond what the way allows [rad/s].
    """
    position, direction, velocity, valid = motion
    here, there = position[begin:], position[begin + 1 :]
    facing, faces = direction[begin:], direction[begin + 1 :]
    before, after = velocity[begin:], velocity[begin + 1 :]
    valid, onward = valid[begin:], valid[begin + 1 :]
    jump = kick = spin = _NEVER
    for t in range(end - begin):
        dx, dy = there[t, 0] - here[t, 0], there[t, 1] - here[t, 1]
        ex = dx - _HALF_STEP * (before[t, 0] + after[t, 0])
        ey = dy - _HALF_STEP * (before[t, 1] + after[t, 1])
        gx, gy = after[t, 0] - before[t, 0], after[t, 1] - before[t, 1]
        ux, uy = faces[t, 0] - facing[t, 0], faces[t, 1] - facing[t, 1]
        turned = np.sqrt(ux * ux + uy * uy) - _TIGHTEST * np.sqrt(dx * dx + dy * dy)  # the chord of a small angle is the angle
        missed, gained = ex * ex + ey * ey, gx * gx + gy * gy
        both = valid[t] and onward[t]
        jump = missed if both and missed > jump else jump
        kick = gained if both and gained > kick else kick
        spin = turned if both and turned > spin else spin
    any_pair = jump >= 0
    return np.sqrt(jump) if any_pair else _NEVER, np.sqrt(kick) if any_pair else _NEVER, spin * _PER_SECOND


@njit(cache=True, error_model="numpy", fastmath={"nnan", "nsz"})
def _highest(whole, window, begin, end):  # type: ignore[no-untyped-def]
    """The highest severities at steps from `begin` to before `end` whose window is whole, in the order of _RULES.

    No stores and no branches, and NaN only where `whole` is false, so that the compiler makes vector instructions of it.
    """
    position, direction, sum_x, sum_y, moment_x, moment_y = window
    # From here on everything is counted from 0: an index that might be negative would be looked into at every step.
    ahead, behind, whole, facing = position[begin + HALF :], position[begin - HALF :], whole[begin:], direction[begin:]
    high_x, high_y, low_x, low_y = (
        sum_x[begin + HALF + 1 :],
        sum_y[begin + HALF + 1 :],
        sum_x[begin - HALF :],
        sum_y[begin - HALF :],
    )
    up_x, up_y, down_x, down_y = (
        moment_x[begin + HALF + 1 :], moment_y[begin + HALF + 1 :], moment_x[begin - HALF :], moment_y[begin - HALF :]
    )  # fmt: skip
    top = gain = loss = turn = error = bend = slip = _NEVER
    for t in range(end - begin):
        total_x, total_y = high_x[t] - low_x[t], high_y[t] - low_y[t]
        vx, vy = np.float32(total_x * _MEAN), np.float32(total_y * _MEAN)
        ax = np.float32((up_x[t] - down_x[t] - (begin + t) * total_x) * _SLOPE)
        ay = np.float32((up_y[t] - down_y[t] - (begin + t) * total_y) * _SLOPE)
        error_x = (ahead[t, 0] - behind[t, 0]) * _SPAN - vx
        error_y = (ahead[t, 1] - behind[t, 1]) * _SPAN - vy
        speed = np.sqrt(vx * vx + vy * vy)
        inverse = _ONE / (max(_CRAWL, speed))
        cos, sin = facing[t, 0], facing[t, 1]
        ux = vx * inverse if speed > _CRAWL else cos
        uy = vy * inverse if speed > _CRAWL else sin
        along, across = ux * ax + uy * ay, abs(ux * ay - uy * ax)
        differs = error_x * error_x + error_y * error_y
        curved = across * inverse * inverse if speed > _STEERING else _ZERO
        slid = max(abs(cos * vy - sin * vx), -(cos * vx + sin * vy))
        here = whole[t]
        top = speed if here and speed > top else top
        gain = along if here and along > gain else gain
        loss = -along if here and -along > loss else loss
        turn = across if here and across > turn else turn
        error = differs if here and differs > error else error
        bend = curved if here and curved > bend else bend
        slip = slid if here and slid > slip else slip
    return top, gain, loss, turn, np.sqrt(error) if error >= 0 else _NEVER, bend, slip
