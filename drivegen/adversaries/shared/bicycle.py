"""A track with other accelerations and curvatures: what an attacker does that knows of no lanes (kinematic bicycle)."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import unit, wrap_angle
from drivegen.core.scenario import DT, Trajectories

LATERAL = 4.0
"""[m/s2] a bend is never taken faster than this allows."""

SLOW = 1.0
"""[m/s] curvature is read off a track above this speed only."""


def perturbed(track: Trajectories, acceleration: NDArray[np.floating], curvature: NDArray[np.floating]) -> Trajectories:
    """Tracks (B, T) from `track` (T,) with changes of acceleration [m/s2] and curvature [1/m], (B, knots) each, held in turn."""
    steps, knots = track.steps, acceleration.shape[1]
    knot = np.minimum(np.arange(steps - 1) * knots // (steps - 1), knots - 1)
    speed = track.speed.astype(np.float64)
    turned = wrap_angle(np.diff(track.heading.astype(np.float64)))
    bend = np.where(speed[1:] > SLOW, turned / np.maximum(speed[1:] * DT, 1e-6), 0.0)
    pace = np.empty((len(acceleration), steps))
    pace[:, 0], heading = speed[0], np.full((len(acceleration), steps), float(track.heading[0]))
    for t in range(steps - 1):
        change = np.diff(speed[t : t + 2]) + acceleration[:, knot[t]] * DT
        pace[:, t + 1] = np.maximum(pace[:, t] + change, 0.0)
        most = LATERAL / np.maximum(pace[:, t + 1], SLOW) ** 2
        heading[:, t + 1] = heading[:, t] + np.clip(bend[t] + curvature[:, knot[t]], -most, most) * pace[:, t + 1] * DT
    velocity = pace[..., None] * unit(heading)
    position = track.position[0] + np.concatenate(
        [np.zeros((len(pace), 1, 2)), np.cumsum((velocity[:, :-1] + velocity[:, 1:]) / 2 * DT, axis=1)], axis=1
    )
    valid = np.broadcast_to(track.valid, pace.shape).copy()
    return Trajectories(position.astype(np.float32), heading.astype(np.float32), velocity.astype(np.float32), valid)
