"""Everything that is replayed, packed for S scenarios at once, in the world and in the frame of the targets' paths.

Replayed motion is known beforehand, so it is projected on the paths once, by a compiled loop, and a step of the simulation
is a few operations on slices.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.world.observation import PATH_SPACING
from drivegen.world.paths import TargetPaths

COARSE = 8
"""The nearest point of a path is searched among every eighth point first ..."""

REFRESH = 10
"""... and that whole search is repeated every tenth step; in between the search goes on from the last point."""

PULL = 0.1
"""A path may come back to where it was. A point of it counts as farther away, by this share of how far along the path it is from
where the target is expected: so of two passes the one is meant that the target makes about then."""


@dataclass(frozen=True)
class Replay:
    """M others of S scenarios over T steps; other m is vehicle m + 1, or, beyond the vehicles, a context actor.

    Attributes:
        steps: (S,) int64 steps of each scenario.
        size: (S, M, 2) float32 [m]. vehicle: (S, M) bool, neither a context actor nor nobody.
        position: (S, T, M, 2) float32 [m]. heading: (S, T, M) [rad]. valid: (S, T, M) bool.
        frame: (S, T, 6, M) float32 along, left, half length, half width, speed along, speed across: see `Observation`.
        target_size: (S, 2) float32 [m]. target_position: (S, 2), target_heading: (S,), target_speed: (S,) at step 0.
        target_along: (S, T) float32 [m] how far along its path each target was planned to be.
    """

    steps: NDArray[np.int64]
    size: NDArray[np.float32]
    vehicle: NDArray[np.bool_]
    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    valid: NDArray[np.bool_]
    frame: NDArray[np.float32]
    target_size: NDArray[np.float32]
    target_position: NDArray[np.float32]
    target_heading: NDArray[np.float32]
    target_speed: NDArray[np.float32]
    target_along: NDArray[np.float32]

    def __getitem__(self, chosen: NDArray[np.intp]) -> "Replay":
        """Scenarios `chosen` (R,), copied."""
        return Replay(*(getattr(self, field.name)[chosen] for field in fields(self)))

    def exchange(
        self, row: NDArray[np.integer], vehicle: NDArray[np.integer], motion: Trajectories, points: Sequence[NDArray[np.float32]]
    ) -> None:
        """Let `vehicle` (E,) of scenario `row` (E,) move as `motion` (E, T) instead, in place.

        `points` (E,) are the paths (P, 2) of the targets; tracks of one path object are projected together.
        """
        other, steps = vehicle - 1, motion.steps
        self.position[row, :steps, other], self.heading[row, :steps, other] = motion.position, motion.heading
        self.valid[row, :, other] = False
        self.valid[row, :steps, other] = motion.valid
        by_path: dict[int, list[int]] = {}
        for e, path in enumerate(points):
            by_path.setdefault(id(path), []).append(e)
        for members in by_path.values():
            some, size = motion[members], self.size[row[members], other[members]]
            arrays = [np.ascontiguousarray(a.swapaxes(0, 1)) for a in (some.position, some.heading, some.velocity, some.valid)]
            frame = np.zeros((steps, 6, len(members)), np.float32)
            expected = np.tile(self.target_along[row[members[0]], :steps, None], len(members))
            project(points[members[0]], expected, *arrays, size, frame)
            self.frame[row[members], :steps, :, other[members]] = np.moveaxis(frame, 2, 0)


def replay(scenarios: Sequence[Scenario], traffic: Sequence[Trajectories], paths: TargetPaths, rows: int) -> Replay:
    """Pack up to `rows` scenarios; missing ones are empty, so that a batch always has the same shape."""
    steps = np.zeros(rows, np.int64)
    steps[: len(traffic)] = [motion.steps for motion in traffic]
    count = max(len(s.vehicles) - 1 + len(s.context) for s in scenarios)
    others, lasts = -(-max(count, 1) // 8) * 8, int(steps.max())
    shape = (rows, lasts, others)
    packed = Replay(
        steps,
        np.ones((rows, others, 2), np.float32),
        np.zeros((rows, others), np.bool_),
        np.zeros((*shape, 2), np.float32),
        np.zeros(shape, np.float32),
        np.zeros(shape, np.bool_),
        np.zeros((rows, lasts, 6, others), np.float32),
        np.ones((rows, 2), np.float32),
        np.zeros((rows, 2), np.float32),
        np.zeros(rows, np.float32),
        np.zeros(rows, np.float32),
        np.zeros((rows, lasts), np.float32),
    )
    velocity = np.zeros((*shape[1:], 2), np.float32)
    for s, (scenario, motion) in enumerate(zip(scenarios, traffic, strict=True)):
        if not motion.valid[TARGET, 0]:
            raise UnusableInput(f"scenario {scenario.scenario_id}: the target is not there at step 0", reason="no-target")
        packed.target_size[s] = scenario.vehicles.size[TARGET, :2]
        packed.target_position[s], packed.target_heading[s] = motion.position[TARGET, 0], motion.heading[TARGET, 0]
        packed.target_speed[s] = motion.speed[TARGET, 0]
        _pack(packed, velocity, s, scenario, motion)
        packed.target_along[s] = progress(motion[TARGET], lasts)
        points, expected = (
            paths.point[s, : int(paths.length[s] / PATH_SPACING) + 1],
            np.tile(packed.target_along[s, :, None], others),
        )
        arrays = (packed.position[s], packed.heading[s], velocity, packed.valid[s], packed.size[s])
        project(points, expected, *arrays, packed.frame[s])
    return packed


def progress(motion: Trajectories, steps: int) -> NDArray[np.float32]:
    """(..., steps) [m] the way of `motion` (..., T) until each step, standing where it ends."""
    ended = motion.standing_after_end().position
    way = np.zeros((*ended.shape[:-2], steps), np.float32)
    way[..., 1 : motion.steps] = np.hypot(*np.moveaxis(np.diff(ended, axis=-2), -1, 0)).cumsum(-1)
    way[..., motion.steps :] = way[..., motion.steps - 1 : motion.steps]
    return way


def _pack(packed: Replay, velocity: NDArray[np.float32], s: int, scenario: Scenario, motion: Trajectories) -> None:
    people = scenario.context
    social, steps = len(scenario.vehicles) - 1, motion.steps
    for rows, moves, size in (
        (slice(0, social), motion[1:], scenario.vehicles.size[1:]),
        (slice(social, social + len(people)), people.motion.until(steps), people.size),
    ):
        lasts = moves.steps
        packed.size[s, rows] = size[:, :2]
        packed.position[s, :lasts, rows] = moves.position.swapaxes(0, 1)
        packed.heading[s, :lasts, rows] = moves.heading.T
        packed.valid[s, :lasts, rows] = moves.valid.T
        velocity[:lasts, rows] = moves.velocity.swapaxes(0, 1)
    packed.vehicle[s, :social] = True


@njit(cache=True, error_model="numpy")
def _gap(points, i, x, y):  # type: ignore[no-untyped-def]
    return (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2


@njit(cache=True, error_model="numpy")
def _nearest(points, x, y, guess, here):  # type: ignore[no-untyped-def]
    """Index of a path point nearest to (x, y): from `guess` downhill, or, where that is -1, after a search around `here` [m]."""
    count = points.shape[0]
    best = guess
    if guess < 0:
        least = np.inf
        for i in range(0, count, COARSE):
            gap = _gap(points, i, x, y) + (PULL * (i * PATH_SPACING - here)) ** 2
            if gap < least:
                best, least = i, gap
    least = _gap(points, best, x, y)
    for way in (1, -1):
        while 0 <= best + way < count:
            gap = _gap(points, best + way, x, y)
            if gap >= least:
                break
            best, least = best + way, gap
    return best


@njit(cache=True, error_model="numpy")
def project(points, expected, position, heading, velocity, valid, size, frame):  # type: ignore[no-untyped-def]
    """Fill `frame` (T, 6, M) with the M boxes (T, M) as seen from the path `points` (P, 2).

    Whoever looks is `expected` (T, M) [m] along the path.
    """
    last = points.shape[0] - 2
    for m in range(valid.shape[1]):
        half_length, half_width = np.float32(0.5) * size[m, 0], np.float32(0.5) * size[m, 1]
        guess = -1
        for t in range(valid.shape[0]):
            if not valid[t, m]:
                guess = -1
                continue
            x, y = position[t, m, 0], position[t, m, 1]
            guess = _nearest(points, x, y, -1 if t % REFRESH == 0 else guess, expected[t, m])
            i = min(guess, last)
            sx, sy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
            dx, dy = x - points[i, 0], y - points[i, 1]
            if i > 0 and sx * dx + sy * dy < 0:  # before this point: on the segment that leads to it
                i -= 1
                sx, sy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
                dx, dy = x - points[i, 0], y - points[i, 1]
            inverse = 1 / np.sqrt(sx * sx + sy * sy)
            ux, uy = sx * inverse, sy * inverse
            hx, hy = np.cos(heading[t, m]), np.sin(heading[t, m])
            cos, sin = abs(ux * hx + uy * hy), abs(ux * hy - uy * hx)
            frame[t, 0, m] = i * PATH_SPACING + (ux * dx + uy * dy) * inverse * PATH_SPACING
            frame[t, 1, m] = ux * dy - uy * dx
            frame[t, 2, m] = half_length * cos + half_width * sin
            frame[t, 3, m] = half_length * sin + half_width * cos
            frame[t, 4, m] = ux * velocity[t, m, 0] + uy * velocity[t, m, 1]
            frame[t, 5, m] = ux * velocity[t, m, 1] - uy * velocity[t, m, 0]
