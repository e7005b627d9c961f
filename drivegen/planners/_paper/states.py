"""Trajectories as the state vectors that planner `paper` denoises, and back."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import rotate, to_vehicle_frame, to_world_frame, wrap_angle
from drivegen.core.scenario import DT, Trajectories
from drivegen.planners.base import PlanRequests

SCALES = {"pose": np.array([30.0, 10.0, 1.0, 1.0, 10.0], np.float32), "position": np.array([30.0, 10.0], np.float32)}
"""What each entry is divided by: x, y [m], cos h, sin h, v [m/s]; x, y [m]. x points ahead at step 0."""

STANDING = 0.02
"""A vehicle that moves less than this per step [m] keeps its heading, where that is taken from positions."""


def conditions(requests: PlanRequests, state: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Scaled initial states and goals (B, S)."""
    at = requests.position.astype(np.float64), requests.heading.astype(np.float64)
    start = _scaled(requests.position[:, None], requests.heading[:, None], requests.speed[:, None], *at, state)
    goal = _scaled(requests.goal_position[:, None], requests.goal_heading[:, None], requests.goal_speed[:, None], *at, state)
    return start[:, 0], goal[:, 0]


def to_states(motion: Trajectories, requests: PlanRequests, state: str, tokens: int) -> NDArray[np.float32]:
    """Scaled states (B, tokens, S) at equal times after the start, the last at the goal; gaps are interpolated."""
    picked = np.empty((4, len(requests), tokens))
    for b in range(len(requests)):
        steps = np.flatnonzero(motion.valid[b])
        at = np.arange(1, tokens + 1) * (requests.goal_step[b] / tokens)
        turned, speed = np.unwrap(motion.heading[b, steps]), motion[b].speed[steps]
        for out, column in zip(picked[:, b], (*motion.position[b, steps].T, turned, speed), strict=True):
            out[:] = np.interp(at, steps, column)
    return _scaled(
        np.moveaxis(picked[:2], 0, -1), picked[2], picked[3], requests.position.astype(np.float64), requests.heading, state
    )


def _scaled(
    position: NDArray[np.floating],
    heading: NDArray[np.floating],
    speed: NDArray[np.floating],
    origin: NDArray[np.floating],
    forward: NDArray[np.floating],
    state: str,
) -> NDArray[np.float32]:
    local = to_vehicle_frame(position.astype(np.float64), origin, forward.astype(np.float64))
    turn = heading - forward[:, None]
    columns = [local[..., 0], local[..., 1], np.cos(turn), np.sin(turn), speed][: len(SCALES[state])]
    return (np.stack(columns, axis=-1) / SCALES[state]).astype(np.float32)


def from_states(states: NDArray[np.float32], requests: PlanRequests, state: str, horizon: NDArray[np.integer]) -> Trajectories:
    """Motion (B, longest horizon) of scaled states (B, T, S); step 0 is the initial state, parked vehicles stay.

    Beyond the goal's step the vehicle goes straight on at the speed it has there.
    """
    values = np.asarray(states * SCALES[state], np.float64)
    position, forward = requests.position.astype(np.float64), requests.heading.astype(np.float64)
    path = np.concatenate([position[:, None], to_world_frame(values[..., :2], position, forward)], axis=1)
    if state == "pose":
        turn = np.arctan2(values[..., 3], values[..., 2])
        heading = np.concatenate([forward[:, None], forward[:, None] + turn], axis=1)
        speed = np.concatenate([requests.speed[:, None], np.maximum(values[..., 4], 0.0)], axis=1)
    else:
        heading, speed = _from_positions(path, requests)
    return _timed(path, np.unwrap(heading, axis=1), speed, requests, horizon)


def _from_positions(path: NDArray[np.float64], requests: PlanRequests) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Headings and speeds (B, T + 1) by differences; a vehicle that stands keeps its heading."""
    step = np.diff(path, axis=1)
    length = np.hypot(step[..., 0], step[..., 1])
    heading, speed = np.empty(path.shape[:2]), np.empty(path.shape[:2])
    heading[:, 0], speed[:, 0] = requests.heading, requests.speed
    duration = np.maximum(requests.goal_step, 1) * DT / step.shape[1]
    for k in range(step.shape[1]):
        moves = length[:, k] > STANDING
        heading[:, k + 1] = np.where(moves, np.arctan2(step[:, k, 1], step[:, k, 0]), heading[:, k])
        speed[:, k + 1] = length[:, k] / duration
    return heading, speed


def _timed(
    path: NDArray[np.float64],
    heading: NDArray[np.float64],
    speed: NDArray[np.float64],
    requests: PlanRequests,
    horizon: NDArray[np.integer],
) -> Trajectories:
    """Read the tokens' states off at the scenario's own steps."""
    motion = Trajectories.empty(len(requests), int(horizon.max(initial=1)))
    motion.valid[:] = np.arange(motion.steps) < horizon[:, None]
    tokens, parked = path.shape[1] - 1, requests.parked
    for b in range(len(requests)):
        steps, goal = np.arange(motion.steps), max(int(requests.goal_step[b]), 1)
        at = np.minimum(steps, goal) * (tokens / goal)
        x, y, h, v = (np.interp(at, np.arange(tokens + 1), a) for a in (path[b, :, 0], path[b, :, 1], heading[b], speed[b]))
        if parked[b]:
            (x[:], y[:]), h[:], v[1:] = requests.position[b], requests.heading[b], 0.0
        on = np.maximum(steps - goal, 0) * DT * v
        motion.position[b] = np.stack([x + on * np.cos(h), y + on * np.sin(h)], axis=-1)
        motion.heading[b] = wrap_angle(h)
        motion.velocity[b] = rotate(np.stack([v, np.zeros_like(v)], axis=-1), h)
    motion.position[:, 0], motion.heading[:, 0] = requests.position, requests.heading
    return motion
