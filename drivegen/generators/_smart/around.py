"""What a vehicle sees at a moment, in its own frame: the nearest pieces of lanes and the nearest others.

Nothing is told in the frame of the scene, so a scene that is turned or shifted is the same scene.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import resample
from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import Scenario
from drivegen.core.signals import SignalState

ROAD_FEATURES = 15
"""Both ends, direction, speed limit, whether it is known, junction, yield, stop, signal closed, signal open; and, on a finer
scale, how far to the side the piece runs and how far beyond its beginning the vehicle is."""

OTHER_FEATURES = 12
"""Place, the same on a finer scale, velocity, direction, speed, length, width, whether it is a vehicle that is driven."""

STATIC = 5

PIECE = 8.0
"""[m] Lanes are cut into straight pieces of about this length."""

REACH, NEAR, PACE = 25.0, 3.0, 10.0
"""[m], [m] and [m/s] that are told as about 1."""

AGAINST = 15.0
"""Lanes that run the other way count as this much farther away [m] when the nearest are chosen."""

LOOK = 1.5
"""[s] The nearest pieces are those around where a vehicle then is at its speed."""


@dataclass(frozen=True)
class Roads:
    """The vehicle lanes of S scenes as straight pieces.

    Attributes:
        start: (S + 1,) int64 first piece of each scene, M at the end. ends: (M, 4) float32 [m] x, y of both ends.
        static: (M, STATIC) float32 speed limit [m/s] (0 unknown), known, in a junction, to yield, to stop.
        signal: (M,) int32 row of `state`, -1 where no signal guards the lane.
        state: (G, T) uint8 SignalState of all scenes' signals, the last one that was known.
    """

    start: NDArray[np.int64]
    ends: NDArray[np.float32]
    static: NDArray[np.float32]
    signal: NDArray[np.int32]
    state: NDArray[np.uint8]

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> "Roads":
        """The lanes of all scenarios."""
        return cls.joined([cls._of(s) for s in scenarios])

    @classmethod
    def _of(cls, scenario: Scenario) -> "Roads":
        roads = scenario.map
        lanes = np.flatnonzero(roads.for_vehicles)
        lines = [resample(roads.centreline[int(i)], PIECE) for i in lanes]
        lane = np.repeat(lanes, [len(line) - 1 for line in lines])
        ends = np.concatenate([np.zeros((0, 4)), *(np.concatenate([line[:-1], line[1:]], axis=1) for line in lines)])
        guard = np.full(len(roads), -1, np.int32)
        guard[scenario.signals.lane] = np.arange(len(scenario.signals))
        limit, control = roads.speed_limit[lane], roads.control[lane]
        yields, stops = np.equal(control, LaneControl.YIELD), np.equal(control, LaneControl.STOP)
        static = np.column_stack([np.nan_to_num(limit), ~np.isnan(limit), roads.in_junction[lane], yields, stops])
        held = scenario.signals.held().state
        return cls(np.array([0, len(lane)]), ends.astype(np.float32), static.astype(np.float32), guard[lane], held)

    @classmethod
    def joined(cls, parts: Sequence["Roads"]) -> "Roads":
        """The scenes of all parts, in order; of signals that were watched for less time the last state is held."""
        steps = max((part.state.shape[1] for part in parts), default=1)
        before, signals = np.cumsum([0, *(len(p.ends) for p in parts)]), np.cumsum([0, *(len(p.state) for p in parts)])
        shifted = [np.where(p.signal < 0, -1, p.signal + n) for p, n in zip(parts, signals, strict=False)]
        held = [np.pad(p.state, ((0, 0), (0, steps - p.state.shape[1])), mode="edge") for p in parts]
        return cls(
            np.concatenate([[0], *(p.start[1:] + shift for p, shift in zip(parts, before, strict=False))]).astype(np.int64),
            np.concatenate([np.zeros((0, 4), np.float32), *(p.ends for p in parts)]),
            np.concatenate([np.zeros((0, STATIC), np.float32), *(p.static for p in parts)]),
            np.concatenate([np.zeros(0, np.int32), *shifted]).astype(np.int32),
            np.concatenate([np.zeros((0, steps), np.uint8), *held]),
        )

    def around(
        self, scene: NDArray[np.integer], state: NDArray[np.float32], shown: NDArray[np.integer], count: int
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """(R, count, ROAD_FEATURES) of the pieces nearest to vehicles in `scene` (R,), and whether they are there.

        `state` (R, 4) x, y, heading, speed. Signals are told as they were at step `shown` (R,).
        """
        when = np.minimum(shown, self.state.shape[1] - 1)
        return _pieces(self.start, self.ends, self.static, self.signal, self.state, scene, state, when, count)  # type: ignore[no-any-return]


def others(
    span: NDArray[np.integer],
    me: NDArray[np.integer],
    state: NDArray[np.float32],
    there: NDArray[np.bool_],
    size: NDArray[np.float32],
    driven: NDArray[np.bool_],
    count: int,
) -> tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.int64]]:
    """The boxes nearest to vehicles `me` (R,), each itself first: (R, T, count, OTHER_FEATURES), whether there, which box.

    Of R vehicles those of the same scene are the boxes `span` (R, 2) from, to; all boxes at T moments: `state` (X, T, 4) x, y,
    heading, speed, `there` (X, T), `size` (X, 2), `driven` (X,).
    """
    return _others(span, me, state, there, size, driven, count)  # type: ignore[no-any-return]


@njit(cache=True)
def _pieces(start, ends, static, signal, shown, scene, state, when, count):  # type: ignore[no-untyped-def]
    out = np.zeros((len(scene), count, ROAD_FEATURES), np.float32)
    there = np.zeros((len(scene), count), np.bool_)
    for r in range(len(scene)):
        first, last = start[scene[r]], start[scene[r] + 1]
        x, y, cos, sin = state[r, 0], state[r, 1], np.cos(state[r, 2]), np.sin(state[r, 2])
        ax, ay = x + cos * state[r, 3] * LOOK, y + sin * state[r, 3] * LOOK
        gap = np.empty(last - first, np.float32)
        for m in range(first, last):
            dx, dy = ends[m, 2] - ends[m, 0], ends[m, 3] - ends[m, 1]
            far = np.hypot((ends[m, 0] + ends[m, 2]) / 2 - ax, (ends[m, 1] + ends[m, 3]) / 2 - ay)
            gap[m - first] = far + AGAINST if dx * cos + dy * sin < -0.5 * np.hypot(dx, dy) else far
        for k, number in enumerate(_nearest(gap, count)):
            m = first + number
            _piece(out[r, k], ends[m], static[m], x, y, cos, sin)
            if signal[m] >= 0:
                shows = shown[signal[m], when[r]]
                out[r, k, 11] = shows == SignalState.RED or shows == SignalState.YELLOW
                out[r, k, 12] = shows == SignalState.GREEN
            there[r, k] = True
    return out, there


@njit(cache=True)
def _nearest(gap, count):  # type: ignore[no-untyped-def]
    """Numbers of the `count` smallest, or of all if there are fewer, in rising order; of equals the first."""
    if len(gap) <= count:
        return np.arange(len(gap))
    farthest = np.partition(gap, count - 1)[count - 1]
    spare, chosen, k = count - (gap < farthest).sum(), np.empty(count, np.int64), 0
    for number in range(len(gap)):
        tie = gap[number] == farthest
        if gap[number] < farthest or (tie and spare > 0):
            chosen[k] = number
            spare -= tie
            k += 1
    return chosen


@njit(cache=True)
def _piece(out, ends, static, x, y, cos, sin):  # type: ignore[no-untyped-def]
    for end in range(2):
        dx, dy = ends[2 * end] - x, ends[2 * end + 1] - y
        out[2 * end], out[2 * end + 1] = (cos * dx + sin * dy) / REACH, (cos * dy - sin * dx) / REACH
    dx, dy = ends[2] - ends[0], ends[3] - ends[1]
    length = max(np.hypot(dx, dy), 1e-3)
    out[4], out[5] = (cos * dx + sin * dy) / length, (cos * dy - sin * dx) / length
    out[6] = static[0] / PACE
    out[7:11] = static[1:5]
    ex, ey = ends[0] - x, ends[1] - y
    out[13] = np.tanh((dx * ey - dy * ex) / length / NEAR)
    out[14] = np.tanh(-(dx * ex + dy * ey) / length / (2 * NEAR))


@njit(cache=True)
def _others(span, me, state, there, size, driven, count):  # type: ignore[no-untyped-def]
    steps = state.shape[1]
    out = np.zeros((len(me), steps, count, OTHER_FEATURES), np.float32)
    seen = np.zeros((len(me), steps, count), np.bool_)
    which = np.zeros((len(me), steps, count), np.int64)
    for r in range(len(me)):
        first, last = span[r]
        for t in range(steps):
            x, y, cos, sin = state[me[r], t, 0], state[me[r], t, 1], np.cos(state[me[r], t, 2]), np.sin(state[me[r], t, 2])
            gap = np.full(last - first, np.inf, np.float32)
            for box in range(first, last):
                if there[box, t]:
                    gap[box - first] = np.hypot(state[box, t, 0] - x, state[box, t, 1] - y)
            gap[me[r] - first] = -1.0
            k = 0
            for box in first + _nearest(gap, count):
                if gap[box - first] < np.inf:
                    k = k + 1 if box != me[r] else k
                    at = 0 if box == me[r] else k
                    _other(out[r, t, at], state[box, t], size[box], driven[box], x, y, cos, sin)
                    seen[r, t, at], which[r, t, at] = True, box
    return out, seen, which


@njit(cache=True)
def _other(out, state, size, driven, x, y, cos, sin):  # type: ignore[no-untyped-def]
    dx, dy, theirs, other = state[0] - x, state[1] - y, np.cos(state[2]), np.sin(state[2])
    out[0], out[1] = (cos * dx + sin * dy) / REACH, (cos * dy - sin * dx) / REACH
    out[2], out[3] = np.tanh(out[0] * REACH / (2 * NEAR)), np.tanh(out[1] * REACH / NEAR)
    out[4], out[5] = cos * theirs + sin * other, cos * other - sin * theirs
    out[6], out[7], out[8] = out[4] * state[3] / PACE, out[5] * state[3] / PACE, state[3] / PACE
    out[9], out[10], out[11] = size[0] / 5, size[1] / 2, driven
