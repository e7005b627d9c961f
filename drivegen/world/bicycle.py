"""Targets that move freely: a kinematic bicycle about the box's centre, within limits, with the route as a path for orientation.

    v' = v + a dt,  beta = atan(tan(delta) / 2),  psi' = psi + v' cos(beta) tan(delta) / L dt
    p' = p + v' (cos, sin)(psi' + beta) dt

with the wheelbase L = 0.6 of the length and the centre in its middle (Polack et al., "The kinematic bicycle model", IV 2017).
"""

import torch
from torch import Tensor

from drivegen.core.scenario import DT
from drivegen.world.ego import FASTEST_START, HARDEST_BRAKING, Ego, foot
from drivegen.world.observation import PATH_SPACING, Action, Paths

WHEELBASE = 0.6
"""Share of a vehicle's length."""

SHARPEST, STEERING_RATE = 0.6, 0.8
"""[rad], [rad/s] Limits of the front wheels' angle and of how fast it changes."""

SEEN = 10
"""Points of the path, ahead and behind, among which the nearest is looked for: nobody gets farther in a step."""

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
    along = _abreast(position, ego.along, paths)
    start, _, direction = foot(along, paths)
    dx, dy = (position - start).unbind(-1)
    offset = direction.cos() * dy - direction.sin() * dx
    turned = heading - direction
    course = turned - 2 * torch.pi * (turned / (2 * torch.pi)).round()
    return Ego(along, offset, course, speed, position, heading, wheel)


def _abreast(position: Tensor, before: Tensor, paths: Paths) -> Tensor:
    """(R,) [m] how far along its path each is at `position` (R, 2): where the path is nearest, within SEEN of `before` (R,).

    Newton's method would need no bound, but leaps where the inside of a bend is farther from the path than its radius.
    """
    row = paths.row(before[:, None] + torch.arange(-SEEN, SEEN + 1, device=before.device) * PATH_SPACING)
    first, last = row == 0, row == paths.row(paths.length[:, None])
    start, direction = paths.point.gather(1, row[..., None].expand(-1, -1, 2)), paths.heading.gather(1, row)
    dx, dy = (position[:, None] - start).unbind(-1)
    cos, sin = direction.cos(), direction.sin()
    beyond, left = cos * dx + sin * dy, cos * dy - sin * dx
    on = torch.where(first, beyond, beyond.clamp_min(0.0))  # the path goes straight on at both ends
    on = torch.where(last, on, on.clamp_max(PATH_SPACING))
    nearest = (left**2 + (beyond - on) ** 2).argmin(1, keepdim=True)
    return (row * PATH_SPACING + on).gather(1, nearest)[:, 0]
