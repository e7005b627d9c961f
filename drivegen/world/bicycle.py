"""Targets that move freely: a kinematic bicycle about the box's centre, within limits, with the route as a path for orientation.

    v' = v + a dt,  beta = atan(tan(delta) / 2),  psi' = psi + v' cos(beta) tan(delta) / L dt
    p' = p + v' (cos, sin)(psi' + beta) dt

with the wheelbase L = 0.6 of the length and the centre in its middle (Polack et al., "The kinematic bicycle model", IV 2017).
"""

import torch
from torch import Tensor

from drivegen.core.scenario import DT
from drivegen.world.ego import Ego, foot
from drivegen.world.observation import Action, Paths

WHEELBASE = 0.6
"""Share of a vehicle's length."""

HARDEST_BRAKING, FASTEST_START = 9.0, 4.0
"""[m/s2] Limits of the acceleration."""

SHARPEST, STEERING_RATE = 0.6, 0.8
"""[rad], [rad/s] Limits of the front wheels' angle and of how fast it changes."""

GRIP = 6.0
"""Largest lateral acceleration [m/s2]: who steers more goes straighter on."""


def freely(ego: Ego, action: Action, paths: Paths, length: Tensor) -> Ego:
    """One step of targets of `length` (R,) [m]; they never drive backwards."""
    acceleration = action.acceleration.clamp(-HARDEST_BRAKING, FASTEST_START)
    speed = (ego.speed + acceleration * DT).clamp_min(0.0)
    steering = torch.zeros_like(speed) if action.steering is None else action.steering
    wheel = torch.minimum(torch.maximum(steering, ego.wheel - STEERING_RATE * DT), ego.wheel + STEERING_RATE * DT)
    base = WHEELBASE * length
    grip = (GRIP * base / speed.clamp_min(0.1) ** 2).atan().clamp_max(SHARPEST)
    wheel = torch.minimum(torch.maximum(wheel, -grip), grip)
    slip = (0.5 * wheel.tan()).atan()
    heading = ego.heading + speed * slip.cos() * wheel.tan() / base * DT
    course = heading + slip
    position = ego.position + (speed * DT)[:, None] * torch.stack([course.cos(), course.sin()], -1)
    return _seen_from_path(ego, position, heading, speed, wheel, paths)


def placed(ego: Ego, position: Tensor, heading: Tensor, paths: Paths) -> Ego:
    """The targets where they are, at `position` (R, 2) and `heading` (R,), in place of abreast on their paths."""
    return _seen_from_path(ego, position, heading, ego.speed, ego.wheel, paths)


def _seen_from_path(ego: Ego, position: Tensor, heading: Tensor, speed: Tensor, wheel: Tensor, paths: Paths) -> Ego:
    """Newton steps on (p - path(along)) . forward(along) = 0 from where the target was abreast before."""
    along = ego.along
    for _ in range(3):
        start, beyond, direction = foot(along, paths)
        cos, sin = direction.cos(), direction.sin()
        dx, dy = (position - start).unbind(-1)
        along = along + cos * dx + sin * dy - beyond
    start, _, direction = foot(along, paths)
    dx, dy = (position - start).unbind(-1)
    offset = direction.cos() * dy - direction.sin() * dx
    turned = heading - direction
    course = turned - 2 * torch.pi * (turned / (2 * torch.pi)).round()
    return Ego(along, offset, course, speed, position, heading, wheel)
