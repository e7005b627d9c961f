"""From what a network says, points every half second in each vehicle's own frame, to motion at 10 Hz on the map.

A cubic spline through the points starts with the vehicle's own speed and heading, so the first frame is met exactly.
Headings follow the motion and are held while it is too slow to tell; what stands and is to go nowhere stays as it is.
"""

from functools import cache

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core.geometry import rotate
from drivegen.core.scenario import DT, Scenario, Trajectories

EVERY = 5
"""Steps between knots."""

KNOTS = 20
"""J, knots at steps EVERY, 2 EVERY, ..., 10 s in all."""

DEGREES = 7
"""Of freedom that a network has in each direction."""

SLOW = 0.5
"""[m/s] Below this speed a direction of motion says nothing about the heading."""

SPREAD = 30.0
"""[m] of one unit of a network's output at the end of the future."""

PARKED_SPEED, PARKED_WAY = 0.3, 1.0
"""[m/s], [m] A vehicle that stands and gets no farther than this stays exactly where it is."""


def at_knots(dense: Tensor) -> Tensor:
    """The knots (..., J, 2) of positions at steps 1..T (..., T, 2)."""
    return dense[..., EVERY - 1 : KNOTS * EVERY : EVERY, :]


@cache
def spline_tables() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions and velocities (T, J + 1) at steps 1..T from (initial speed, knots) along an axis that starts at 0.

    The cubic spline with knots at 0 and the J points, its slope given at the start and its curvature 0 at the end.
    """
    h, count = EVERY * DT, KNOTS
    system, given = np.eye(count + 1), np.zeros((count + 1, count + 1))
    given[0, 0] = 1.0
    for j in range(1, count):
        system[j, j - 1 : j + 2] = 1.0, 4.0, 1.0
        given[j, j + 1] = 3.0 / h
        if j > 1:
            given[j, j - 1] = -3.0 / h
    system[count, count - 1 : count + 1] = 1.0, 2.0
    given[count, count], given[count, count - 1] = 3.0 / h, -3.0 / h
    slopes = np.linalg.solve(system, given).astype(np.float64)  # at each knot, from (initial speed, knots)
    values = np.eye(count + 1)
    values[0, 0] = 0.0
    step = np.arange(1, count * EVERY + 1)
    piece = (step - 1) // EVERY
    u = (step / EVERY - piece)[:, None]
    y0, y1, m0, m1 = values[piece], values[piece + 1], slopes[piece] * h, slopes[piece + 1] * h
    position = (2 * u**3 - 3 * u**2 + 1) * y0 + (u**3 - 2 * u**2 + u) * m0 + (3 * u**2 - 2 * u**3) * y1 + (u**3 - u**2) * m1
    velocity = (6 * u**2 - 6 * u) * (y0 - y1) + (3 * u**2 - 4 * u + 1) * m0 + (3 * u**2 - 2 * u) * m1
    return position, velocity / h


@cache
def smoothing_table() -> NDArray[np.float64]:
    """(J, J) the projection of knots on smooth curves that start at rest: u^2 times polynomials of less than DEGREES, u = t / T.

    A network that says J knots freely needs long to learn not to jerk; this leaves it what vehicles do within 10 s.
    """
    share = np.arange(1, KNOTS + 1) / KNOTS
    curves = share[:, None] ** 2 * np.polynomial.legendre.legvander(2 * share - 1, DEGREES - 1)
    basis, _ = np.linalg.qr(curves)
    return np.asarray(basis @ basis.T)


class Onward(nn.Module):
    """Knots of who goes straight on at its initial speed, and of what a network adds to that, the more the later."""

    smoothing: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("smoothing", torch.from_numpy(smoothing_table()).float(), persistent=False)

    def forward(self, speed: Tensor, added: Tensor) -> Tensor:
        """(..., J, 2) [m] in the vehicles' frames, from speeds (...) [m/s] and any numbers (..., J, 2)."""
        share = torch.arange(1, KNOTS + 1, device=added.device) / KNOTS
        straight = speed[..., None] * share * (KNOTS * EVERY * DT)
        onward = torch.stack([straight, torch.zeros_like(straight)], dim=-1)
        return onward + self.smoothing @ (added * (SPREAD * share[:, None]))


def filled_in(knots: NDArray[np.float32], speed: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Positions and velocities (..., T, 2) at steps 1..T through knots (..., J, 2), all in the vehicles' own frames.

    `speed` (...) [m/s] at step 0, along x.
    """
    start = np.zeros((*knots.shape[:-2], 1, 2), np.float32)
    start[..., 0, 0] = speed
    given = np.concatenate([start, knots], axis=-2)
    position, velocity = (np.einsum("tj,...jc->...tc", table.astype(np.float32), given) for table in spline_tables())
    return position, velocity


def trajectories(scenario: Scenario, position: NDArray[np.float32], velocity: NDArray[np.float32]) -> Trajectories:
    """Motion (K, N, scenario's steps) on the map from positions and velocities (K, N, T, 2) in the vehicles' own frames.

    Step 0 is the scenario's own; beyond T vehicles go straight on.
    """
    vehicles, steps = scenario.vehicles, scenario.steps
    way = np.hypot(position[..., 0], position[..., 1]).max(axis=-1, initial=0)
    parked = (vehicles.speed < PARKED_SPEED) & (way < PARKED_WAY)
    position, velocity = _cut_or_continued(position, velocity, steps - 1)
    position[parked], velocity[parked] = 0, 0
    heading = vehicles.heading[:, None]
    made = Trajectories.empty(*position.shape[:2], steps)
    made.position[:, :, 0] = vehicles.position
    made.position[:, :, 1:] = vehicles.position[:, None] + rotate(position, heading)
    made.velocity[:, :, 0, 0] = vehicles.speed * np.cos(vehicles.heading)
    made.velocity[:, :, 0, 1] = vehicles.speed * np.sin(vehicles.heading)
    made.velocity[:, :, 1:] = rotate(velocity, heading)
    made.heading[:] = _headings(made.velocity, vehicles.heading)
    made.valid[:] = True
    return made


def _cut_or_continued(
    position: NDArray[np.float32], velocity: NDArray[np.float32], steps: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The first `steps` steps; what is missing goes on at the last velocity."""
    missing = steps - position.shape[2]
    if missing <= 0:
        return position[:, :, :steps].copy(), velocity[:, :, :steps].copy()
    later = np.arange(1, missing + 1, dtype=np.float32)[:, None] * np.float32(DT)
    on = position[:, :, -1:] + velocity[:, :, -1:] * later
    return np.concatenate([position, on], axis=2), np.concatenate([velocity, np.repeat(velocity[:, :, -1:], missing, 2)], axis=2)


def _headings(velocity: NDArray[np.float32], first: NDArray[np.float32]) -> NDArray[np.float32]:
    """(K, N, steps) direction of motion, or the last one that could be told; the given heading (N,) at step 0."""
    moving = np.hypot(velocity[..., 0], velocity[..., 1]) >= SLOW
    moving[..., 0] = True
    heading = np.arctan2(velocity[..., 1], velocity[..., 0])
    heading[..., 0] = first
    last = np.maximum.accumulate(np.where(moving, np.arange(moving.shape[-1]), 0), axis=-1)
    return np.take_along_axis(heading, last, axis=-1)
