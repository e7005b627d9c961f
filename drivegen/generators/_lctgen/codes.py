"""LCTGen's scenario code: small whole numbers for each vehicle around the target (paper, section 4.1).

A vehicle's eight fields are its quadrant and distance as seen from the target, its direction, its speed, and what it
does in each of four equal parts of the future. The first four are seen at step 0; the actions are the log's, or somebody's.
"""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import rotate, wrap_angle
from drivegen.core.scenario import DT, Scenario
from drivegen.generators.shared.vectors import STEPS, Scenes


class Action(IntEnum):
    """What a vehicle does in a part of the future."""

    STOP = 0
    TURN_LEFT = 1
    CHANGE_LEFT = 2
    SLOW_DOWN = 3
    KEEP_SPEED = 4
    SPEED_UP = 5
    CHANGE_RIGHT = 6
    TURN_RIGHT = 7


class Direction(IntEnum):
    """Which way a vehicle faces as seen from the target."""

    SAME = 0
    LEFTWARD = 1
    OPPOSITE = 2
    RIGHTWARD = 3


PARTS = 4
"""Parts of the future, 2.5 s each."""

DISTANCE, DISTANCES = 5.0, 21
"""[m] of a bin and number of bins of the distance from the target; the last is open."""

SPEED, SPEEDS = 2.5, 16
"""[m/s] of a bin and number of bins of the speed; the last is open."""

SIZES = (4, DISTANCES, len(Direction), SPEEDS) + PARTS * (len(Action),)
"""Values that each field takes."""

TURN = np.deg2rad(20.0)
"""[rad] A part with a greater change of heading is a turn ..."""

SIDEWAYS = 1.0
"""... and one with more of a sideways way than this [m], but no turn, a lane change."""

STANDING = 1.0
"""[m/s] slower than this at a part's end is a stop."""

FASTER, SLOWER = 0.5, -1.0
"""[m/s2] mean accelerations beyond which a vehicle speeds up, slows down."""


def state_code(scenes: Scenes) -> NDArray[np.int64]:
    """(S, A, 4) quadrant, distance, direction and speed in the first frame: the fields before the actions."""
    x, y = scenes.position[..., 0], scenes.position[..., 1]
    quadrant = np.where(x >= 0, np.where(y >= 0, 0, 3), np.where(y >= 0, 1, 2))
    distance = np.minimum(np.hypot(x, y) / DISTANCE, DISTANCES - 1)
    direction = np.round(scenes.heading / (np.pi / 2)) % len(Direction)
    speed = np.minimum(scenes.speed / SPEED, SPEEDS - 1)
    return np.stack([quadrant, distance, direction, speed], axis=-1).astype(np.int64)


def logged_actions(scenes: Scenes) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Actions (S, A, PARTS), and whether the log saw both ends of the part."""
    position = np.concatenate([scenes.position[:, :, None], scenes.future], axis=2)
    heading = np.concatenate([scenes.heading[:, :, None], scenes.future_heading], axis=2)
    logged = np.concatenate([scenes.present[:, :, None], scenes.logged], axis=2)
    edges = np.arange(PARTS + 1) * (STEPS // PARTS)
    speed, clocked = _speeds(scenes, position, logged, edges)
    begin, end = edges[:-1], edges[1:]
    sideways = rotate(position[:, :, end] - position[:, :, begin], -heading[:, :, begin])[..., 1]
    turn = wrap_angle(heading[:, :, end] - heading[:, :, begin])
    gain = np.diff(speed, axis=2) / (STEPS // PARTS * DT)
    first_that_holds = {
        Action.STOP: speed[:, :, 1:] < STANDING,
        Action.TURN_LEFT: turn > TURN,
        Action.TURN_RIGHT: turn < -TURN,
        Action.CHANGE_LEFT: sideways > SIDEWAYS,
        Action.CHANGE_RIGHT: sideways < -SIDEWAYS,
        Action.SPEED_UP: gain > FASTER,
        Action.SLOW_DOWN: gain < SLOWER,
    }
    action = np.select(list(first_that_holds.values()), list(first_that_holds), Action.KEEP_SPEED)
    seen = logged[:, :, begin] & logged[:, :, end] & clocked[:, :, 1:] & clocked[:, :, :-1]
    return np.asarray(action, np.int64), seen


def _speeds(
    scenes: Scenes, position: NDArray[np.float32], logged: NDArray[np.bool_], edges: NDArray[np.intp]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Speeds (S, A, PARTS + 1) at the parts' edges over the half second before, the initial one at step 0; and if known."""
    before = np.maximum(edges - 5, 0)
    way = position[:, :, edges] - position[:, :, before]
    speed = np.hypot(way[..., 0], way[..., 1]) / (5 * DT)
    speed[:, :, 0] = scenes.speed
    return speed.astype(np.float32), logged[:, :, edges] & logged[:, :, before]


def logged_code(scenario: Scenario) -> NDArray[np.int64]:
    """The code (N, 8) of a scenario by its log; who is not seen is said to keep its speed."""
    scenes = Scenes.with_logs([scenario])
    actions, logged = logged_actions(scenes)
    code = np.concatenate([state_code(scenes), np.where(logged, actions, Action.KEEP_SPEED)], axis=-1)
    return np.asarray(code[0, : len(scenario.vehicles)])
