"""What a vehicle does on its way to where it ends: turns, lane changes, stops."""

from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.roads.line import SPACING, Route
from drivegen.roads.parked import STANDING

NO_MOVE = 0.5
"""Who ends within this distance [m] along its route has stayed."""

TURN = np.deg2rad(35)
"""Heading change inside junctions from which on a way is a turn [rad] ..."""

U_TURN = np.deg2rad(140)
"""... or, with what bends before and behind them, a U-turn: a narrow one begins before its junction does."""


class Manoeuvre(IntEnum):
    """What a vehicle does on its way to a candidate."""

    KEEP = 0
    LEFT = 1
    RIGHT = 2
    CHANGE_LEFT = 3
    CHANGE_RIGHT = 4
    U_TURN = 5
    STOP = 6
    STAY = 7
    OFF_LANE = 8
    PARK = 9


_KEEP, _LEFT, _RIGHT, _CHANGE_LEFT, _CHANGE_RIGHT, _U_TURN, _STOP, _STAY = map(int, list(Manoeuvre)[:8])  # for compiled code


def manoeuvres(route: Route | None, s: Floats | float, final: Floats | float) -> NDArray[np.uint8]:
    """Manoeuvre (...) of ending on `route` at `s` (...) [m] with `final` (...) [m/s]; OFF_LANE without a route.

    Turns inside junctions count before lane changes, both before stopping.
    """
    if route is None:
        return np.full(np.shape(s), Manoeuvre.OFF_LANE, np.uint8)
    place, pace = np.broadcast_arrays(np.asarray(s, np.float64), np.asarray(final, np.float64))
    kinds: NDArray[np.uint8] = _kinds(place.ravel(), pace.ravel(), route.heading, route.turned, route.shift)
    return kinds.reshape(place.shape)


@njit(cache=True)
def _kinds(s, final, heading, turned, shift):  # type: ignore[no-untyped-def]
    kinds = np.empty(len(s), np.uint8)
    for i in range(len(s)):
        at = int(min(max(s[i] / SPACING, 0.0), len(heading) - 1.0))
        if s[i] < NO_MOVE and final[i] < STANDING:
            kinds[i] = _STAY
        elif abs(heading[at] - heading[0]) > U_TURN and abs(turned[at]) > U_TURN / 2:  # some of it on the way in
            kinds[i] = _U_TURN
        elif abs(turned[at]) > TURN:
            kinds[i] = _LEFT if turned[at] > 0 else _RIGHT
        elif shift[at] != 0:
            kinds[i] = _CHANGE_LEFT if shift[at] > 0 else _CHANGE_RIGHT
        else:
            kinds[i] = _STOP if final[i] < STANDING else _KEEP
    return kinds
