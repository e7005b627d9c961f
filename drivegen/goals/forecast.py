"""Where drivers of usual habits would be at the end on one route: the queue ahead is driven on together with the vehicle.

Everybody whose middle is on the route ahead of the vehicle follows the Intelligent Driver Model (Treiber, Hennecke and
Helbing, 2000) along it, one behind the other, under the route's speed limits and bends and stops at signals while they
are closed. It is a yardstick for candidates, not a planner: nobody turns off, changes lanes or gives way.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.scenario import DT
from drivegen.core.signals import Signals
from drivegen.goals.traffic import STAND, Ahead, Queue
from drivegen.roads.line import SPACING, Route
from drivegen.roads.reach import Dynamics, speed_caps

ACCELERATION, BRAKING, HEADWAY, MIN_GAP = 1.6, 2.5, 1.1, 2.0
"""A usual driver's acceleration and comfortable braking [m/s2], time gap [s] and gap at a standstill [m]."""

HARD = 4.5
"""Who would have to brake harder than this [m/s2] for a signal drives on."""

HARDEST = 8.0
"""Nobody brakes harder [m/s2]."""

JAM_BRAKING = 1.2
"""How the head of a queue brakes for a jam [m/s2]."""

CALM_SHARE = 0.8
"""A calm driver's desired speed and acceleration, as a share of the usual."""

LEAST_KEEN, MOST_KEEN = 0.4, 1.3
"""Who drives less than this share of what the road allows is held up by something; nobody wants to drive more than that."""

LATERAL = 4.0
"""Most lateral acceleration in bends [m/s2]."""

UNKNOWN_LIMIT = 12.0
"""Where a map has no speed limits a vehicle is taken to want this [m/s], or what it drives if that is more."""

STRIDE = 2
"""Steps of a scenario per step of the forecast."""


class Habit(IntEnum):
    """What the vehicle and the one at the head of the queue do; columns of a forecast.

    USUAL: all drive as they like. KEEPING: the head keeps its speed, all others theirs where the road lets them. JAM: the
    head brakes to a halt, as for traffic that is not in the scenario. CALM: the vehicle is driven slowly. WAITING: it stands
    at the next way into a junction where it may have to wait. ALONE: it sees neither queue nor signals.
    """

    USUAL = 0
    KEEPING = 1
    JAM = 2
    CALM = 3
    WAITING = 4
    ALONE = 5


_KEEPING, _JAM, _CALM, _WAITING, _ALONE = (int(habit) for habit in list(Habit)[1:])  # for compiled code


@dataclass(frozen=True)
class Forecast:
    """Where the vehicle is at the end on one route.

    Attributes:
        s: (H,) [m] along the route, one per Habit. speed: (H,) [m/s] there.
    """

    s: NDArray[np.float64]
    speed: NDArray[np.float64]


def forecast(route: Route, speed: float, length: float, ahead: Ahead, queue: Queue, signals: Signals, steps: int) -> Forecast:
    """Drive a vehicle of `length` [m] with `speed` [m/s] at s = 0 on for `steps` steps behind `queue`."""
    caps = speed_caps(route, max(speed, 0.0), Dynamics(ACCELERATION, BRAKING, LATERAL, 1.0))
    wanted = _wanted(caps, route.speed_limit, np.float32(max(UNKNOWN_LIMIT, speed)))
    place, pace, size = _in_line(speed, length, queue.s, queue.speed, queue.length)
    entry, last = ahead.entry_s + length / 2, steps // STRIDE
    walls, closed = _signals_ahead(route.entries, route.lane, signals.lane, signals.closed, last)
    end = _drive(wanted, place, pace, size, walls, closed, entry, last, STRIDE * DT)
    return Forecast(end[:, 0], end[:, 1])


@njit(cache=True)
def _wanted(caps, limit, unknown):  # type: ignore[no-untyped-def]
    """(P,) [m/s] what is driven under `caps` (P,) at most; without a speed limit nobody wants more than `unknown`."""
    wanted = np.empty(len(caps))
    for k in range(len(caps)):
        wanted[k] = min(caps[k], unknown) if np.isnan(limit[k]) else caps[k]
    return wanted


@njit(cache=True)
def _in_line(speed, length, places, speeds, lengths):  # type: ignore[no-untyped-def]
    """Places, speeds and lengths (1 + M,) of the vehicle, which is at 0 m, and of the queue before it."""
    whole = np.empty((3, 1 + len(places)))
    whole[0, 0], whole[1, 0], whole[2, 0] = 0.0, speed, length
    whole[0, 1:], whole[1, 1:], whole[2, 1:] = places, speeds, lengths
    return whole


@njit(cache=True)
def _signals_ahead(entries, lane, signal_lane, closed, steps):  # type: ignore[no-untyped-def]
    """Where to stand (W,) [m] before the signals on the route, and whether each is closed (W, steps) at every STRIDE-th step."""
    walls, shut, count = (
        np.empty(len(entries) * len(signal_lane)),
        np.empty((len(entries) * len(signal_lane), steps), np.bool_),
        0,
    )
    for at in entries:
        for g in range(len(signal_lane)):
            if signal_lane[g] == lane[at]:
                walls[count] = at * SPACING - STAND
                for step in range(steps):
                    shut[count, step] = closed[g, min(step * STRIDE, closed.shape[1] - 1)]
                count += 1
    return walls[:count], shut[:count]


@njit(cache=True)
def _interaction(v, closing, gap):  # type: ignore[no-untyped-def]
    """Braking term of the model before what is `gap` [m] ahead."""
    desired_gap = MIN_GAP + max(v * HEADWAY + v * closing / (2 * np.sqrt(ACCELERATION * BRAKING)), 0.0)
    return (desired_gap / max(gap, 0.1)) ** 2


@njit(cache=True)
def _stop(v, gap):  # type: ignore[no-untyped-def]
    """Braking term before a place to stand `gap` [m] ahead of the bumper, STAND before a line; none for who is past the
    line or would have to brake too hard for it.
    """
    if gap < -STAND or v * v > 2 * HARD * (gap + STAND):
        return 0.0
    return _interaction(v, v, gap + MIN_GAP)


@njit(cache=True)
def _keenness(caps, s, v, habit):  # type: ignore[no-untyped-def]
    """Desired speed (M,) of each vehicle as a share of the road's."""
    keen = np.ones(len(s))
    for i in range(len(s)):
        now = min(v[i] / max(caps[min(max(int(s[i] / SPACING), 0), len(caps) - 1)], 1.0), MOST_KEEN)
        keen[i] = now if habit == _KEEPING and now > LEAST_KEEN else max(now, 1.0)
    if habit == _CALM:
        keen[0] *= CALM_SHARE
    return keen


@njit(cache=True)
def _gain(v, desired, brake, head, own, habit, dt):  # type: ignore[no-untyped-def]
    """Acceleration [m/s2] of one vehicle; who is faster than desired slows down at a comfortable rate."""
    over = v / desired
    free = 1 - over**4 if over < 1 else -min((v - desired) / dt, BRAKING) / ACCELERATION
    gain = ACCELERATION * (free - brake)
    if head and habit == _KEEPING:
        gain = min(gain, 0.0)
    if head and habit == _JAM:
        gain = min(gain, -JAM_BRAKING)
    if own and habit == _CALM and gain > 0:
        gain *= CALM_SHARE
    return max(gain, -HARDEST)


@njit(cache=True)
def _drive(caps, place, pace, size, walls, closed, entry, steps, dt):  # type: ignore[no-untyped-def]
    """Position and speed (H, 2) of the first vehicle at the end, once per habit."""
    result = np.empty((_ALONE + 1, 2))
    for habit in range(_ALONE + 1):
        count = 1 if habit == _ALONE else len(place)
        s, v = place[:count].copy(), pace[:count].copy()
        keen = _keenness(caps, s, v, habit)
        for step in range(steps):
            for i in range(count - 1, -1, -1):
                head = i == count - 1
                desired = max(caps[min(max(int(s[i] / SPACING), 0), len(caps) - 1)] * keen[i], 0.5)
                brake = 0.0 if head else _interaction(v[i], v[i] - v[i + 1], s[i + 1] - s[i] - (size[i] + size[i + 1]) / 2)
                front = s[i] + size[i] / 2
                for w in range(len(walls) if habit != _ALONE else 0):
                    if closed[w, step]:
                        brake = max(brake, _stop(v[i], walls[w] - front))
                if habit == _WAITING and i == 0:
                    brake = max(brake, _stop(v[0], entry - front))
                after = max(v[i] + _gain(v[i], desired, brake, head, i == 0, habit, dt) * dt, 0.0)
                s[i] += (v[i] + after) / 2 * dt
                v[i] = after
        result[habit, 0], result[habit, 1] = s[0], v[0]
    return result
