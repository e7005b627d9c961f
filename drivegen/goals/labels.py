"""Where each vehicle of a log ended: seen, or for one that left the scene early carried on as it was last seen.

Leaving out those that leave would teach that nobody ever leaves: on a motorway they are a third of all.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, unit
from drivegen.core.scenario import DT, Scenario
from drivegen.goals.candidates import Candidates
from drivegen.roads.frenet import from_frenet, to_frenet

LEAST_SEEN = 0.3
"""A track seen for less than this share of the horizon teaches nothing."""

UNSTEADY = 0.8
"""How uncertain the acceleration of a vehicle is once it is out of sight [m/s2]."""

ON_ROUTE = 2.0
"""A vehicle last seen within this distance [m] of a route's line is carried on along it."""


@dataclass(frozen=True)
class Ends:
    """V vehicles whose end can be a label.

    Attributes:
        vehicle: (V,) their numbers. position: (V, 2) [m] of the end. doubt: (V,) [m] standard deviation, 0 where it was seen.
    """

    vehicle: NDArray[np.intp]
    position: NDArray[np.float64]
    doubt: NDArray[np.float64]


def ends(scenario: Scenario, candidates: Sequence[Candidates]) -> Ends:
    """The ends of all vehicles that were seen at step 0 and for long enough; none without a log."""
    log = scenario.log
    if log is None:
        return Ends(np.zeros(0, np.intp), np.zeros((0, 2)), np.zeros(0))
    last = log.last_valid()
    rows = np.flatnonzero(log.valid[:, 0] & (last >= LEAST_SEEN * scenario.horizon))
    left = (scenario.horizon - last[rows]) * DT
    position = log.position[rows, last[rows]].astype(np.float64)
    for i in np.flatnonzero(left).tolist():
        n, step = int(rows[i]), int(last[rows[i]])
        onward = float(log.speed[n, step]) * left[i]
        position[i] = _carried_on(candidates[n], position[i], float(log.heading[n, step]), onward)
    return Ends(rows, position, UNSTEADY * left**2 / 2)


def _carried_on(c: Candidates, position: Floats, heading: float, onward: float) -> Floats:
    """`position` (2,) moved `onward` [m] along the nearest route, straight on where none is near."""
    frenet = np.array([to_frenet(route, position[None])[0] for route in c.routes]).reshape(-1, 2)
    if len(frenet) and np.abs(frenet[:, 1]).min() < ON_ROUTE:
        number = int(np.argmin(np.abs(frenet[:, 1]).round(1)))  # the likeliest of those that share the stretch
        s, d = frenet[number]
        place: Floats = from_frenet(c.routes[number], np.array([s + onward]), np.array([d]))[0][0]
        return place
    straight: Floats = position + onward * unit(np.asarray(heading))
    return straight
