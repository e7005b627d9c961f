"""What traffic on a route waits for: the next signal, when it opens and closes, and the queue before and beyond its line.

A queue whose head stands at a closed signal goes when that opens; one whose head stands elsewhere waits for something that
is not seen, and may stay.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.scenario import DT
from drivegen.core.signals import Signals
from drivegen.goals.traffic import HALTED, STAND, Ahead, Queue
from drivegen.roads.line import SPACING, Route

NEVER = 12.0
"""Stands for later than the horizon [s]."""

IN_SIGHT = 60.0
"""Where nothing makes a line to wait at, the queue is who is within this distance [m]; no gap is told farther."""

AT_LINE = 8.0
"""Who has halted with its front within this distance of a line [m] waits there: nobody else has room before it."""

NOBODY = 15.0
"""The speed [m/s] that stands for that of a vehicle where there is none."""


@dataclass(frozen=True)
class Waiting:
    """What a vehicle at s = 0 finds on one route.

    Attributes:
        signal: whether the line belongs to a signal whose states are known.
        opens, closes: [s] until it first is open, closed; 0 if it is so now, NEVER if not within the states that are known.
        open_share: share of the time for which it is open; 1 without a signal.
        line: [m] along the route to the signal's stop line, else to the next way into a junction where one may have to
            wait; inf without either.
        queued: vehicles ahead before the line. head_gap: [m] from the front of the first of them (of the vehicle itself
            if there is none) to the line. head_speed: its speed [m/s].
        beyond_gap, beyond_speed: [m] from the line to the middle of the next vehicle beyond, and its speed [m/s].
    """

    signal: bool
    opens: float
    closes: float
    open_share: float
    line: float
    queued: int
    head_gap: float
    head_speed: float
    beyond_gap: float
    beyond_speed: float

    @classmethod
    def on(cls, route: Route, speed: float, length: float, ahead: Ahead, queue: Queue, signals: Signals) -> "Waiting":
        """For a vehicle of `length` [m] and `speed` [m/s], with what is `ahead` and the whole `queue` on `route`."""
        line, closed = _next_signal(route, signals)
        if closed is None:
            line, times = ahead.entry_s + length / 2 + STAND, (0.0, NEVER, 1.0)  # `Ahead` tells it for a centre that stands
        else:
            times = (_first(~closed), _first(closed), float(1 - closed.mean()))
        last = line if np.isfinite(line) else IN_SIGHT
        before = int(np.count_nonzero(queue.s < last))
        s, pace, size = 0.0, speed, length
        if before:
            s, pace, size = (float(a[before - 1]) for a in (queue.s, queue.speed, queue.length))
        gap = line - s - size / 2 if np.isfinite(line) else IN_SIGHT
        beyond = (float(queue.s[before]) - last, float(queue.speed[before])) if before < len(queue.s) else (IN_SIGHT, NOBODY)
        return cls(closed is not None, *times, line, before, gap, pace, *beyond)

    @property
    def explained(self) -> bool:
        """Whether the queue's head stands at the line of a signal that is closed now."""
        return self.head_speed < HALTED and self.opens > 0 and self.head_gap < AT_LINE


def _next_signal(route: Route, signals: Signals) -> tuple[float, NDArray[np.bool_] | None]:
    """Where the route enters the first lane with a known signal [m], and whether that is closed (T,); (inf, None) without one."""
    at, which = _first_shown(route.entries, route.lane, signals.lane, signals.shown)
    return (np.inf, None) if which < 0 else (at * SPACING, signals.closed[which])


@njit(cache=True)
def _first_shown(entries, lane, signal_lane, shown):  # type: ignore[no-untyped-def]
    """Point and number of the first signal on the route that is ever known; -1, -1 without one."""
    for at in entries:
        for g in range(len(signal_lane)):
            if shown[g] and signal_lane[g] == lane[at]:
                return at, g
    return -1, -1


def _first(when: NDArray[np.bool_]) -> float:
    """The first time [s] at which `when` (T,) holds."""
    return float(np.argmax(when)) * DT if when.any() else NEVER
