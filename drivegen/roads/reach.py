"""How far a vehicle can get along a route: speed profiles between braking hard and accelerating.

A profile is found in two passes over the route's points, as in time-optimal path parametrisation: speed is capped by the
limit and by lateral acceleration in bends; a backward pass makes every cap reachable by braking, a forward pass bounds
acceleration.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.core.settings import Positive
from drivegen.roads.line import SPACING, Route

UNLIMITED = 25.0
"""Where a map has no speed limits, nobody is expected to want more than this [m/s] or than he already drives."""


@dataclass(frozen=True)
class Dynamics:
    """Bounds on how a vehicle changes speed.

    Attributes:
        acceleration, braking, lateral: most acceleration forward, backward and sideways [m/s2].
        limit_factor: how far above the speed limit it drives at most.
    """

    acceleration: Positive
    braking: Positive
    lateral: Positive
    limit_factor: Positive


def speed_caps(route: Route, speed: float, dynamics: Dynamics) -> NDArray[np.float32]:
    """(P,) [m/s] most speed at each point of the route for a vehicle that drives `speed` at s = 0."""
    limits = route.speed_limit, np.float32(dynamics.limit_factor), np.float32(max(UNLIMITED, speed))
    caps: NDArray[np.float32] = _caps(route.heading, *limits, dynamics.lateral, dynamics.braking, SPACING)
    return caps


def travelled(caps: NDArray[np.float32], speed: float, acceleration: float, braking: float, seconds: float) -> float:
    """Distance [m] after `seconds` at full `acceleration` under `caps`; on the last cap beyond the route's end."""
    return float(_travelled(caps, speed, acceleration, braking, seconds, SPACING))


def stopping_distance(speed: float, braking: float, seconds: float) -> float:
    """Least distance [m] covered in `seconds` when braking hard."""
    time = min(speed / braking, seconds)
    return speed * time - braking * time**2 / 2


def end_speed(distance: NDArray[np.floating], speed: float, caps: NDArray[np.floating], seconds: float) -> NDArray[np.float32]:
    """Speed [m/s] with which `distance` (C,) [m] is reached after `seconds`, between 0 and `caps` (C,).

    That of the cubic s(t) of least squared acceleration through both positions and the initial speed: its acceleration
    fades to zero at the end, so v(T) = 3/2 s/T - v(0)/2.
    """
    final: Floats = np.minimum(np.maximum(1.5 * distance / seconds - 0.5 * speed, 0.0), caps)
    return final.astype(np.float32)


@njit(cache=True)
def _caps(heading, limit, factor, unknown, lateral, braking, spacing):  # type: ignore[no-untyped-def]
    caps = np.where(np.isnan(limit), unknown, limit * factor)
    count = len(caps)
    for k in range(count):
        window = int(min(max(caps[k] / 3, 2.0), 15.0) / spacing)  # fast roads are drawn with few vertices: kinks are no bends
        a, b = max(k - window, 0), min(k + window, count - 1)
        bend = abs(heading[b] - heading[a]) / ((b - a) * spacing)
        caps[k] = min(caps[k], np.sqrt(lateral / max(bend, 1e-4)))
    for k in range(count - 2, -1, -1):
        caps[k] = min(caps[k], np.sqrt(caps[k + 1] ** 2 + 2 * braking * spacing))
    return caps


@njit(cache=True)
def _travelled(caps, speed, acceleration, braking, seconds, spacing):  # type: ignore[no-untyped-def]
    left, now = seconds, speed
    for k in range(1, len(caps)):
        least = np.sqrt(max(now * now - 2 * braking * spacing, 0.0))
        following = max(min(np.sqrt(now * now + 2 * acceleration * spacing), caps[k]), least)
        needed = 2 * spacing / max(now + following, 1e-3)
        if needed >= left:
            gained = (following * following - now * now) / (2 * spacing)
            return (k - 1) * spacing + min(max(now * left + gained * left * left / 2, 0.0), spacing)
        left, now = left - needed, following
    return (len(caps) - 1) * spacing + now * left
