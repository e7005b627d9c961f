"""What BITS's networks see of a vehicle: a raster of the lanes and of the boxes around it, heading up.

The lanes of a scene are painted once; a vehicle's raster is cut out of that and the boxes are drawn into it. That is a
hundred times cheaper than drawing polygons for each vehicle of each sample at each replanning (`roads.raster`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import line_heading, resample
from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import Scenario
from drivegen.core.signals import SignalState
from drivegen.generators.shared.closed_loop import Crowd
from drivegen.store.columns import Held, Rows, Starts, joined

ROWS, COLUMNS = 48, 32
"""Pixels of a vehicle's raster; row 0 is farthest ahead, column 0 leftmost."""

PIXEL = (2.5, 2.0)
"""Length and width of a pixel [m]."""

BEHIND = 20.0
"""The raster begins so far behind the vehicle [m]; it reaches 100 m ahead and 32 m to each side."""

FAST = 80.0
"""Who gets farther than this [m] until the horizon sees a raster that is stretched lengthwise in proportion."""

CHANNELS = 11
"""lane, its direction along and across, speed limit, way to yield or stop on, closed by a signal, box, its velocity along and
across, distance to where constant velocity leads at the horizon along and across."""

CELL = 1.5
"""Edge of a cell of a painted scene [m]."""

PLANES = 5
"""Of a painted cell: lanes over it, sums of their directions x and y, highest speed limit, way to yield or stop on."""

NOTHING = -1
"""No lane over a cell; no signal that guards it."""

_MARGIN = 4.0
_HALF = (1.5, 2.5)  # [m] least and most half width that is painted
_PACE = 10.0
_ALONG, _ACROSS = 20.0, 4.0
_FARTHEST = 120.0  # [m] boxes beyond are not in the picture


@dataclass(frozen=True)
class Painted:
    """The lanes of S scenes as grids; most cells are empty, so only the numbers of painted ones are kept.

    Attributes:
        first: (S + 1,) int64 first cell of each scene's grid. shape: (S, 2) int64 rows (y) and columns (x).
        origin: (S, 2) float32 [m] centre of the cell in row 0, column 0.
        number: (cells,) int32 row of `planes`, or NOTHING.
        planes: (P, PLANES) float32. signal: (P,) int32 row of `state`, or NOTHING.
        state: (G, T) uint8 SignalState of all scenes' signals; the last one is held where a scene is shorter.
    """

    first: Annotated[NDArray[np.int64], Starts("number")]
    shape: NDArray[np.int64]
    origin: NDArray[np.float32]
    number: Annotated[NDArray[np.int32], Rows("planes")]
    planes: NDArray[np.float32]
    signal: Annotated[NDArray[np.int32], Rows("state")]
    state: Annotated[NDArray[np.uint8], Held()]

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> "Painted":
        """Paint the vehicle lanes of each scenario."""
        return joined(cls, [cls._of(s) for s in scenarios])

    @classmethod
    def _of(cls, scenario: Scenario) -> "Painted":
        map_ = scenario.map
        lanes = np.flatnonzero(map_.for_vehicles)
        lines = [resample(map_.centreline[int(i)], CELL) for i in lanes]
        lane = np.repeat(lanes, [len(line) for line in lines])
        points = np.concatenate([np.zeros((0, 2), np.float32), *lines])
        heading = np.concatenate([np.zeros(0, np.float32), *map(line_heading, lines)])
        width = np.hypot(*(map_.left.points[map_.left.start[:-1]] - map_.right.points[map_.right.start[:-1]]).T)
        low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(2), np.ones(2))
        low = np.floor(low - _MARGIN).astype(np.float32)
        shape = (np.ceil((high + _MARGIN - low) / CELL).astype(np.int64) + 1)[::-1]
        guard = np.full(len(map_), NOTHING, np.int32)
        guard[scenario.signals.lane] = np.arange(len(scenario.signals))
        number, planes, signal = _paint(
            points - low, heading, np.clip(width / 2, *_HALF)[lane], np.nan_to_num(map_.speed_limit)[lane],
            np.isin(map_.control, (LaneControl.YIELD, LaneControl.STOP))[lane], guard[lane], shape[0], shape[1],
        )  # fmt: skip
        return cls(
            np.array([0, len(number)]),
            shape[None],
            np.asarray(low[None], np.float32),
            number,
            planes,
            signal,
            scenario.signals.held().state,
        )

    @classmethod
    def none(cls) -> "Painted":
        """No scene."""
        count, pair, planes = np.zeros(0, np.int32), np.zeros((0, 2)), np.zeros((0, PLANES), np.float32)
        state = np.zeros((0, 1), np.uint8)
        return cls(np.zeros(1, np.int64), pair.astype(np.int64), pair.astype(np.float32), count, planes, count, state)


@njit(cache=True)
def _paint(points, heading, half, limit, waits, guard, rows, columns):  # type: ignore[no-untyped-def]
    """Discs of each lane's half width along its centreline, one per cell's length."""
    number = np.full(rows * columns, NOTHING, np.int32)
    for turn in range(2):  # first the painted cells are counted, then filled in
        planes = np.zeros((0 if turn == 0 else number.max() + 1, PLANES), np.float32)
        signal = np.full(len(planes), NOTHING, np.int32)
        painted = 0
        for p in range(len(points)):
            reach = int(np.ceil(half[p] / CELL))
            j0, i0 = int(np.rint(points[p, 0] / CELL)), int(np.rint(points[p, 1] / CELL))
            for i in range(max(i0 - reach, 0), min(i0 + reach + 1, rows)):
                for j in range(max(j0 - reach, 0), min(j0 + reach + 1, columns)):
                    if (i * CELL - points[p, 1]) ** 2 + (j * CELL - points[p, 0]) ** 2 > half[p] ** 2:
                        continue
                    if turn == 0:
                        if number[i * columns + j] == NOTHING:
                            number[i * columns + j] = painted
                            painted += 1
                        continue
                    at = number[i * columns + j]
                    planes[at, 0] += 1
                    planes[at, 1] += np.cos(heading[p])
                    planes[at, 2] += np.sin(heading[p])
                    planes[at, 3] = max(planes[at, 3], limit[p])
                    planes[at, 4] = max(planes[at, 4], np.float32(waits[p]))
                    if guard[p] >= 0:
                        signal[at] = guard[p]
    return number, planes, signal


@njit(cache=True)
def painted_at(first, shape, origin, number, scene, x, y):  # type: ignore[no-untyped-def]
    """Row of `planes` at a place of a scene's map, NOTHING where no lane is."""
    row, column = int(np.rint((y - origin[scene, 1]) / CELL)), int(np.rint((x - origin[scene, 0]) / CELL))
    if row < 0 or column < 0 or row >= shape[scene, 0] or column >= shape[scene, 1]:
        return NOTHING
    return number[first[scene] + row * shape[scene, 1] + column]


def stretch(speed: NDArray[np.floating], horizon: float) -> NDArray[np.float32]:
    """By how much longer than PIXEL the pixels of vehicles at `speed` (R,) [m/s] are; `horizon` in seconds."""
    return np.asarray(np.maximum(speed * (horizon / FAST), 1.0), np.float32)


def rasters(painted: Painted, crowd: Crowd, box: NDArray[np.integer], horizon: float) -> NDArray[np.float32]:
    """(R, CHANNELS, ROWS, COLUMNS) of vehicles `box` (R,) of the crowd.

    `horizon` [s] is how far ahead constant velocity is told.
    """
    out, group = np.zeros((len(box), CHANNELS, ROWS, COLUMNS), np.float32), crowd.group(box)
    shown = np.minimum(crowd.step[group], painted.state.shape[1] - 1)
    longer = stretch(np.hypot(crowd.state[box, 3], crowd.state[box, 4]), horizon)
    _lanes(
        out, painted.first, painted.shape, painted.origin, painted.number, painted.planes, painted.signal, painted.state,
        crowd.state[box], longer, crowd.scene[group], shown, horizon,
    )  # fmt: skip
    _boxes(out, crowd.start, crowd.state, crowd.there, crowd.size, longer, group, box)
    return out


@njit(cache=True)
def _lanes(out, first, shape, origin, number, planes, signal, state, pose, longer, scene, step, horizon):  # type: ignore[no-untyped-def]
    for r in range(len(pose)):
        x, y, cos, sin = pose[r, 0], pose[r, 1], np.cos(pose[r, 2]), np.sin(pose[r, 2])
        reach = np.hypot(pose[r, 3], pose[r, 4]) * horizon
        for i in range(ROWS):
            along = ((ROWS - i - 0.5) * PIXEL[0] - BEHIND) * longer[r]
            out[r, 9, i] = np.tanh((along - reach) / _ALONG)
            for j in range(COLUMNS):
                across = (COLUMNS / 2 - j - 0.5) * PIXEL[1]
                out[r, 10, i, j] = np.tanh(across / _ACROSS)
                at = painted_at(
                    first, shape, origin, number, scene[r], x + cos * along - sin * across, y + sin * along + cos * across
                )
                if at >= 0:
                    _cell(out[r, :, i, j], planes[at], cos, sin)
                    if signal[at] >= 0:
                        shown = state[signal[at], step[r]]
                        out[r, 5, i, j] = shown == SignalState.RED or shown == SignalState.YELLOW


@njit(cache=True)
def _cell(pixel, cell, cos, sin):  # type: ignore[no-untyped-def]
    pixel[0] = 1.0
    pixel[1] = (cos * cell[1] + sin * cell[2]) / cell[0]
    pixel[2] = (cos * cell[2] - sin * cell[1]) / cell[0]
    pixel[3], pixel[4] = cell[3] / _PACE, cell[4]


@njit(cache=True)
def _boxes(out, start, state, there, size, longer, group, box):  # type: ignore[no-untyped-def]
    """Every other box as points half a pixel apart."""
    for r in range(len(box)):
        me = box[r]
        cos, sin = np.cos(state[me, 2]), np.sin(state[me, 2])
        for other in range(start[group[r]], start[group[r] + 1]):
            dx, dy = state[other, 0] - state[me, 0], state[other, 1] - state[me, 1]
            if other == me or not there[other] or np.hypot(dx, dy) > _FARTHEST * longer[r]:
                continue
            c, s = np.cos(state[other, 2] - state[me, 2]), np.sin(state[other, 2] - state[me, 2])
            x, y = cos * dx + sin * dy, cos * dy - sin * dx
            vx, vy = cos * state[other, 3] + sin * state[other, 4], cos * state[other, 4] - sin * state[other, 3]
            longwise, crosswise = int(np.ceil(size[other, 0])) + 1, int(np.ceil(size[other, 1])) + 1
            for a in range(longwise):
                for b in range(crosswise):
                    u = (a / (longwise - 1) - 0.5) * size[other, 0]
                    w = (b / (crosswise - 1) - 0.5) * size[other, 1]
                    i = ROWS - 1 - int(np.floor(((x + c * u - s * w) / longer[r] + BEHIND) / PIXEL[0]))
                    j = COLUMNS // 2 - 1 - int(np.floor((y + s * u + c * w) / PIXEL[1]))
                    if 0 <= i < ROWS and 0 <= j < COLUMNS:
                        out[r, 6, i, j] = 1.0
                        out[r, 7, i, j], out[r, 8, i, j] = vx / _PACE, vy / _PACE
