"""What a vehicle does on its way to where it ends: turns, lane changes, stops."""

from enum import IntEnum

import numpy as np
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


def manoeuvres(route: Route | None, s: Floats | float, final: Floats | float) -> NDArray[np.uint8]:
    """Manoeuvre (...) of ending on `route` at `s` (...) [m] with `final` (...) [m/s]; OFF_LANE without a route.

    Turns inside junctions count before lane changes, both before stopping.
    """
    if route is None:
        return np.full(np.shape(s), Manoeuvre.OFF_LANE, np.uint8)
    at = np.clip(np.asarray(s) / SPACING, 0, len(route.line) - 1).astype(int)
    turned, shift = route.turned[at], route.shift[at]
    kind = np.where(np.asarray(final) < STANDING, Manoeuvre.STOP, Manoeuvre.KEEP)
    kind = np.where(shift > 0, Manoeuvre.CHANGE_LEFT, np.where(shift < 0, Manoeuvre.CHANGE_RIGHT, kind))
    kind = np.where(turned > TURN, Manoeuvre.LEFT, np.where(turned < -TURN, Manoeuvre.RIGHT, kind))
    back = (np.abs(route.heading[at] - route.heading[0]) > U_TURN) & (np.abs(turned) > U_TURN / 2)  # some of it on the way in
    kind = np.where(back, Manoeuvre.U_TURN, kind)
    still = (np.asarray(s) < NO_MOVE) & (np.asarray(final) < STANDING)
    return np.where(still, Manoeuvre.STAY, kind).astype(np.uint8)
