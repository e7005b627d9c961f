"""Speed along the route: a base that meets both ends exactly, and a smooth residual about it.

With T the duration, v0 and v1 the speeds at the ends, D the distance and f(x) = 1 - 3x^2 + 2x^3 a smooth ramp (area 1/2):

* D >= T (v0 + v1) / 2:  v(t) = v0 f(t/T) + v1 f(1 - t/T) + b 30 (t/T)^2 (1 - t/T)^2, the bump b making up the distance;
* else brake and go:     v(t) = v0 f(t/R) + v1 f((T - t)/R) with R = 2 D / (v0 + v1), standing in between if R < T/2.

Both are never negative and cover exactly D, which a cubic through both ends does not: it overshoots the place where a
vehicle stops and drives back. The residual is a cubic B-spline over t/T whose value and slope vanish at both ends.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

KNOTS = 20
"""Spline intervals over the duration (or over the distance, for the lateral residual): one per 0.5 s of 10 s."""

COEFFICIENTS = KNOTS - 1
"""Free coefficients: KNOTS + 3 less two at each end."""


@njit(cache=True, inline="always")
def _ramp(x: float) -> float:
    return 1.0 - x * x * (3.0 - 2.0 * x) if x < 1.0 else 0.0


@njit(cache=True)
def base_speed(t: float, duration: float, distance: float, v0: float, v1: float) -> float:
    """The base's speed [m/s] at time t [s]; all arguments zero or more."""
    u = t / duration
    missing = distance - duration * (v0 + v1) / 2
    if missing >= 0:
        return float(v0 * _ramp(u) + v1 * _ramp(1 - u) + missing / duration * 30 * u * u * (1 - u) * (1 - u))
    ramp = 2 * distance / (v0 + v1)
    if ramp <= 0:
        return 0.0
    return float(v0 * _ramp(t / ramp) + v1 * _ramp((duration - t) / ramp))


def spline(u: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values and slopes (U, COEFFICIENTS) of the residual's basis functions at u (U,) in [0, 1].

    Uniform cubic B-splines about the knots 2 .. KNOTS - 2, and at each end the one combination of the three about the
    knots -1, 0, 1 whose value and slope are zero there (its curvature is not: a vehicle may start by accelerating).
    """
    x = np.asarray(u, np.float64)[:, None] * KNOTS - np.arange(-1, KNOTS + 2)[None, :]
    weights = list(zip(range(-2, 3), (1, -4, 6, -4, 1), strict=True))
    value = np.sum([c * np.maximum(x - k, 0) ** 3 for k, c in weights], axis=0) / 6
    slope = np.sum([c * np.maximum(x - k, 0) ** 2 for k, c in weights], axis=0) / 2 * KNOTS
    return _fixed_at_ends(value), _fixed_at_ends(slope)


def _fixed_at_ends(full: NDArray[np.float64]) -> NDArray[np.float64]:
    first = full[:, :3] @ [1.0, -0.5, 1.0]
    last = full[:, -3:] @ [1.0, -0.5, 1.0]
    return np.column_stack([first, full[:, 3:-3], last])
