"""Speeds, accelerations and turning of tracks, by central differences of positions and headings as in Waymo's Sim Agents metrics.

A difference at a step needs the steps before and after it, one of second order four neighbours: `within` says where it is
known. Velocities that a method reports are not used here: every method is judged by where its vehicles are.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import wrap_angle
from drivegen.core.scenario import DT, Trajectories


@dataclass(frozen=True)
class Kinematics:
    """Motion of tracks, each (..., T) float32; zero where the differences are not known.

    Attributes:
        speed: [m/s]. acceleration: change of speed [m/s2]. jerk: change of acceleration [m/s3].
        turning: angular speed [rad/s], to the left positive. angular_acceleration: [rad/s2].
        lateral: speed times angular speed [m/s2].
    """

    speed: NDArray[np.float32]
    acceleration: NDArray[np.float32]
    jerk: NDArray[np.float32]
    turning: NDArray[np.float32]
    angular_acceleration: NDArray[np.float32]
    lateral: NDArray[np.float32]


def kinematics(motion: Trajectories) -> Kinematics:
    """Kinematics of motion (..., T); mask them with `within` of the steps that are known."""
    x, y = _central(motion.position[..., 0]), _central(motion.position[..., 1])
    speed = np.hypot(x, y)
    turn = np.zeros_like(motion.heading)
    turn[..., 1:-1] = wrap_angle(motion.heading[..., 2:] - motion.heading[..., :-2])
    turning = turn / np.float32(2 * DT)
    acceleration = _central(speed)
    return Kinematics(speed, acceleration, _central(acceleration), turning, _central(turning), speed * turning)


def within(known: NDArray[np.bool_], order: int) -> NDArray[np.bool_]:
    """(..., T) where central differences of this order have all their neighbours: 0 is `known` itself."""
    for _ in range(order):
        inner = np.zeros_like(known)
        inner[..., 1:-1] = known[..., 2:] & known[..., :-2]
        known = inner
    return known


def _central(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Rate of change (..., T) [1/s] over both neighbours; zero at both ends."""
    out = np.zeros_like(values)
    out[..., 1:-1] = (values[..., 2:] - values[..., :-2]) / np.float32(2 * DT)
    return out
