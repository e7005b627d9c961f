"""Vehicle lanes of scenes as straight pieces, and those nearest to a vehicle in its own frame.

Nothing is told in the frame of the scene, so a scene that is turned or shifted is the same scene.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import resample
from drivegen.core.roadmap import LaneControl, RoadMap
from drivegen.core.scenario import Scenario
from drivegen.core.signals import SignalState
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.store.columns import Held, Rows, Starts, joined

LANE_FEATURES = 15
"""Both ends, direction, speed limit, whether it is known, junction, yield, stop, signal closed, signal open; and, on
the finer scale of NEAR, how far to the side the line runs and how far beyond its beginning the vehicle is."""

STATIC = 5

REACH, PACE = 25.0, 10.0
"""Metres and metres per second that are told as 1."""

NEAR = 3.0
"""Distances [m] are told once more, so that a few of them fill the scale."""

AGAINST = 15.0
"""Lanes that run the other way count as this much farther away [m] when the nearest are chosen."""


@dataclass(frozen=True)
class LaneVectors:
    """The vehicle lanes of S scenes, cut into straight pieces.

    Attributes:
        start: (S + 1,) int64 first piece of each scene, M at the end.
        ends: (M, 4) float32 [m] x, y of both ends in driving direction.
        static: (M, STATIC) float32 speed limit [m/s] (0 unknown), known, in a junction, to yield, to stop.
        signal: (M,) int32 row of `state`, -1 where no signal guards the lane.
        state: (G, T) uint8 SignalState of all scenes' signals; the last state is held where a scene is shorter.
    """

    start: Annotated[NDArray[np.int64], Starts("ends")]
    ends: NDArray[np.float32]
    static: NDArray[np.float32]
    signal: Annotated[NDArray[np.int32], Rows("state")]
    state: Annotated[NDArray[np.uint8], Held()]

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], length: float) -> "LaneVectors":
        """Pieces of about `length` [m]."""
        return joined(cls, [cls._of(s, length) for s in scenarios])

    @classmethod
    def _of(cls, scenario: Scenario, length: float) -> "LaneVectors":
        lane, ends = pieces(scenario.map, length)
        guard = np.full(len(scenario.map), -1, np.int32)
        guard[scenario.signals.lane] = np.arange(len(scenario.signals))
        limit, control = scenario.map.speed_limit[lane], scenario.map.control[lane]
        yields, stops = np.equal(control, LaneControl.YIELD), np.equal(control, LaneControl.STOP)
        static = np.column_stack([np.nan_to_num(limit), ~np.isnan(limit), scenario.map.in_junction[lane], yields, stops])
        return cls(np.array([0, len(lane)]), ends, static.astype(np.float32), guard[lane], scenario.signals.held().state)

    @classmethod
    def none(cls) -> "LaneVectors":
        """No scene."""
        ends, static = np.zeros((0, 4), np.float32), np.zeros((0, STATIC), np.float32)
        return cls(np.zeros(1, np.int64), ends, static, np.zeros(0, np.int32), np.zeros((0, 1), np.uint8))

    def around(
        self,
        pose: NDArray[np.float32],
        scene: NDArray[np.integer],
        step: NDArray[np.integer],
        count: int,
        look: float,
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """(R, count, LANE_FEATURES) of the pieces nearest to where vehicles will be after `look` [s], and whether they are there.

        `pose` (R, 5) x, y, heading, velocity in x and y, on the map of `scene` (R,). Signals are told as they are at `step` (R,).
        """
        step = np.minimum(step, self.state.shape[1] - 1)
        return _lanes(self.start, self.ends, self.static, self.signal, self.state, pose, scene, step, count, look)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Logs:
    """Logged scenes: who is where, and the lanes."""

    tracks: Tracks
    lanes: LaneVectors

    def __len__(self) -> int:
        return len(self.tracks.start) - 1

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], length: float) -> "Logs":
        """Those of scenarios that have a log; pieces of about `length` [m]."""
        logged = [s for s in scenarios if s.log is not None]
        return cls(Tracks.of_logs(logged), LaneVectors.of(logged, length))

    @classmethod
    def none(cls) -> "Logs":
        """No scene."""
        return cls(Tracks.none(), LaneVectors.none())


def pieces(road_map: RoadMap, length: float) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Lanes (M,) and ends (M, 4) of the straight pieces of all vehicle lanes."""
    lanes = np.flatnonzero(road_map.for_vehicles)
    lines = [resample(road_map.centreline[int(i)], length) for i in lanes]
    lane = np.repeat(lanes, [len(line) - 1 for line in lines])
    ends = [np.concatenate([line[:-1], line[1:]], axis=1) for line in lines]
    return lane, np.concatenate([np.zeros((0, 4)), *ends]).astype(np.float32)


@njit(cache=True)
def _lanes(start, ends, static, signal, state, pose, scene, step, count, look):  # type: ignore[no-untyped-def]
    """(R, count, LANE_FEATURES) and (R, count)."""
    out = np.zeros((len(pose), count, LANE_FEATURES), np.float32)
    there = np.zeros((len(pose), count), np.bool_)
    for r in range(len(pose)):
        first, last = start[scene[r]], start[scene[r] + 1]
        x, y, cos, sin = pose[r, 0], pose[r, 1], np.cos(pose[r, 2]), np.sin(pose[r, 2])
        ax, ay = x + pose[r, 3] * look, y + pose[r, 4] * look
        distance = np.empty(last - first, np.float32)
        for m in range(first, last):
            dx, dy = ends[m, 2] - ends[m, 0], ends[m, 3] - ends[m, 1]
            gap = np.hypot((ends[m, 0] + ends[m, 2]) / 2 - ax, (ends[m, 1] + ends[m, 3]) / 2 - ay)
            distance[m - first] = gap + AGAINST if dx * cos + dy * sin < -0.5 * np.hypot(dx, dy) else gap
        for k, m in enumerate(nearest(distance, count) + first):
            _lane(out[r, k], ends[m], static[m], x, y, cos, sin)
            if signal[m] >= 0:
                shown = state[signal[m], step[r]]
                out[r, k, 11] = shown == SignalState.RED or shown == SignalState.YELLOW
                out[r, k, 12] = shown == SignalState.GREEN
            there[r, k] = True
    return out, there


@njit(cache=True)
def nearest(distance, count):  # type: ignore[no-untyped-def]
    """Numbers of the `count` smallest, or of all if there are fewer, in rising order; of equals the first."""
    if len(distance) <= count or count == 0:
        return np.arange(min(len(distance), count))
    farthest = np.partition(distance, count - 1)[count - 1]
    chosen = np.empty(count, np.int64)
    spare, k = count - (distance < farthest).sum(), 0
    for number in range(len(distance)):
        tie = distance[number] == farthest
        if distance[number] < farthest or (tie and spare > 0):
            chosen[k] = number
            spare -= tie
            k += 1
    return chosen


@njit(cache=True)
def _lane(out, ends, static, x, y, cos, sin):  # type: ignore[no-untyped-def]
    for end in range(2):
        dx, dy = ends[2 * end] - x, ends[2 * end + 1] - y
        out[2 * end], out[2 * end + 1] = (cos * dx + sin * dy) / REACH, (cos * dy - sin * dx) / REACH
    dx, dy = ends[2] - ends[0], ends[3] - ends[1]
    length = max(np.hypot(dx, dy), 1e-3)
    out[4], out[5] = (cos * dx + sin * dy) / length, (cos * dy - sin * dx) / length
    out[6] = static[0] / PACE
    ex, ey = ends[0] - x, ends[1] - y
    out[13] = np.tanh((dx * ey - dy * ex) / length / NEAR)
    out[14] = np.tanh(-(dx * ex + dy * ey) / length / (2 * NEAR))
    out[7:11] = static[1:5]
