"""Where something must hold before a vehicle may drive on: the gates of a map, and the conflict points behind them.

A gate is the stop line of a lane, or the start of the lane where no line is mapped, together with a signal, a stop sign or
a duty to yield. Priority over who has to wait there have ways that never wait (FREE) or have a light, and those of which the map
says so (`RoadMap.yields_to`). Where it does not, nobody is judged among ways that all wait, since their order can't be told from
their shapes (LOG.md, "giving way among ways that all wait").

Lanes that begin at the same line are siblings: which of them a vehicle took shows only later, so free siblings of guarded lanes
are gates too, with nothing to hold.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from drivegen.core.roadmap import LaneControl, RoadMap
from drivegen.core.signals import Signals, SignalState

HALF_WIDTH = 2.5
"""Half the width over which a gate is crossed [m]."""

SIBLING_REACH = 2.0
"""Lanes whose gates lie this close [m] and point the same way are siblings."""

_SAME_POINT = 0.5


@dataclass(frozen=True)
class Gates:
    """The G gates of one scenario.

    Attributes:
        position: (G, 2) float32 [m] middle of the line. direction: (G, 2) float32 unit vector of the lane behind it.
        group: (G,) int32 the same for siblings.
        start, end: (G,) int32 rows of `line`, the centreline of the lane behind the gate.
        line: (P, 2) float32 [m].
        red_for: (G, T) int16 number of steps for which the signal has been red, 0 while it is not or there is none.
        stop, give_way: (G,) bool.
        conflict_start: (G + 1,) int32 rows of the conflicts of each gate.
        conflict: (C, 2) float32 [m] points where lanes with priority cross or join the gate's lane.
        conflict_direction: (C, 2) float32 unit vectors of these lanes there.
    """

    position: NDArray[np.float32]
    direction: NDArray[np.float32]
    group: NDArray[np.int32]
    start: NDArray[np.int32]
    end: NDArray[np.int32]
    line: NDArray[np.float32]
    red_for: NDArray[np.int16]
    stop: NDArray[np.bool_]
    give_way: NDArray[np.bool_]
    conflict_start: NDArray[np.int32]
    conflict: NDArray[np.float32]
    conflict_direction: NDArray[np.float32]

    @classmethod
    def of(cls, map_: RoadMap, signals: Signals) -> "Gates":
        """All gates of a map under these signals."""
        waits = np.isin(map_.control, (LaneControl.STOP, LaneControl.YIELD))
        lanes = _guarded_and_siblings(map_, waits | np.isin(np.arange(len(map_)), signals.lane))
        start, end = map_.centreline.start[lanes], map_.centreline.start[lanes + 1]
        points = map_.centreline.points
        step = points[start + 1] - points[start]
        direction = step / np.maximum(np.hypot(step[:, :1], step[:, 1:]), 1e-6)
        position = _line_middles(map_, lanes, points[start])
        conflicts = _conflicts(map_, lanes, waits)
        counts = np.array([len(at) for at, _ in conflicts], np.int64)
        return cls(
            position.astype(np.float32),
            direction.astype(np.float32),
            _siblings(position, direction),
            start.astype(np.int32),
            end.astype(np.int32),
            points,
            _red_for(lanes, signals),
            map_.control[lanes] == LaneControl.STOP,
            waits[lanes],
            np.concatenate([[0], np.cumsum(counts)]).astype(np.int32),
            np.concatenate([at for at, _ in conflicts] + [_NO_CONFLICTS[0]]),
            np.concatenate([towards for _, towards in conflicts] + [_NO_CONFLICTS[1]]),
        )

    def __len__(self) -> int:
        return len(self.group)


def _guarded_and_siblings(map_: RoadMap, guarded: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Guarded vehicle lanes, and the free ones that begin where one of them does: whoever takes those may go."""
    at = map_.centreline.points[map_.centreline.start[:-1]]
    gap = at[:, None] - at[None, guarded & map_.for_vehicles]
    beside = (np.abs(gap).sum(axis=-1) < _SAME_POINT).any(axis=1)
    return np.flatnonzero(map_.for_vehicles & beside)


_Conflicts = tuple[NDArray[np.float32], NDArray[np.float32]]
_NO_CONFLICTS: _Conflicts = (np.zeros((0, 2), np.float32), np.zeros((0, 2), np.float32))


def _line_middles(map_: RoadMap, lanes: NDArray[np.intp], starts: NDArray[np.float32]) -> NDArray[np.float32]:
    middle = starts.copy()
    for line, lane in zip(map_.stop_lines, map_.stop_lane, strict=True):
        middle[lanes == lane] = line.mean(axis=0)
    return middle


def _siblings(position: NDArray[np.float32], direction: NDArray[np.float32]) -> NDArray[np.int32]:
    """(G,) the first gate of each one's group: gates that are near, and those that are near these in turn.

    A group is judged when its first gate is, so that one has to be in it: of three directions a fan apart the outer ones are not
    near each other.
    """
    gap = position[:, None] - position[None]
    near = (np.hypot(gap[..., 0], gap[..., 1]) < SIBLING_REACH) & (direction @ direction.T > np.cos(np.pi / 6))
    group: NDArray[np.int32] = connected_components(near, directed=False)[1]
    return np.asarray(np.unique(group, return_index=True)[1][group], np.int32)


def _red_for(lanes: NDArray[np.intp], signals: Signals) -> NDArray[np.int16]:
    """(G, T) steps since the signal turned red, this one included; since step 0 where it was red from the start."""
    red = np.zeros((len(lanes), signals.state.shape[1]), np.bool_)
    for lane, state in zip(signals.lane, signals.state, strict=True):
        red[lanes == lane] |= state == SignalState.RED
    count = np.zeros(red.shape, np.int16)
    for t in range(red.shape[1]):
        count[:, t] = np.where(red[:, t], (count[:, t - 1] if t else 0) + 1, 0)
    return count


def _conflicts(map_: RoadMap, lanes: NDArray[np.intp], waits: NDArray[np.bool_]) -> list[_Conflicts]:
    """Points and directions of the junction lanes with priority that cross each lane that `waits`, or end where it ends."""
    usable, line = map_.in_junction & map_.for_vehicles, map_.centreline
    free = np.isin(map_.control, (LaneControl.FREE, LaneControl.SIGNAL))

    def conflicts(lane: int) -> _Conflicts:
        first = free.copy()
        first[map_.yields_to[map_.yields_to[:, 0] == lane, 1]] = True
        crossing: _Conflicts = _crossing_points(
            line.points, line.start, np.int32(lane), np.flatnonzero(first & usable).astype(np.int32)
        )
        return crossing

    return [conflicts(lane) if waits[lane] else _NO_CONFLICTS for lane in lanes.tolist()]


@njit(cache=True)
def _crossing_points(points, starts, lane, others):  # type: ignore[no-untyped-def]
    at = np.zeros((others.shape[0], 2), np.float32)
    towards = np.zeros((others.shape[0], 2), np.float32)
    count = 0
    for other in others:
        if other == lane:
            continue
        crosses, x, y, dx, dy = first_crossing(points, starts[lane], starts[lane + 1], starts[other], starts[other + 1])
        if crosses:
            at[count, 0], at[count, 1], towards[count, 0], towards[count, 1] = x, y, dx, dy
            count += 1
    return at[:count], towards[:count]


@njit(cache=True)
def first_crossing(points, a0, a1, b0, b1):  # type: ignore[no-untyped-def]
    """Where line b first crosses line a, or their common end; siblings, which share their start, don't conflict."""
    if abs(points[a0, 0] - points[b0, 0]) + abs(points[a0, 1] - points[b0, 1]) < _SAME_POINT:
        return False, 0.0, 0.0, 0.0, 0.0
    for i in range(a0, a1 - 1):
        px, py = points[i, 0], points[i, 1]
        rx, ry = points[i + 1, 0] - px, points[i + 1, 1] - py
        for j in range(b0, b1 - 1):
            sx, sy = points[j + 1, 0] - points[j, 0], points[j + 1, 1] - points[j, 1]
            cross = rx * sy - ry * sx
            if abs(cross) < 1e-9:
                continue
            qx, qy = points[j, 0] - px, points[j, 1] - py
            t, u = (qx * sy - qy * sx) / cross, (qx * ry - qy * rx) / cross
            if 0 <= t <= 1 and 0 <= u <= 1:
                length = np.sqrt(sx * sx + sy * sy)
                return True, px + t * rx, py + t * ry, sx / length, sy / length
    x, y = points[a1 - 1, 0], points[a1 - 1, 1]
    if abs(x - points[b1 - 1, 0]) + abs(y - points[b1 - 1, 1]) < _SAME_POINT:
        sx, sy = points[b1 - 1, 0] - points[b1 - 2, 0], points[b1 - 1, 1] - points[b1 - 2, 1]
        length = max(np.sqrt(sx * sx + sy * sy), 1e-9)
        return True, x, y, sx / length, sy / length
    return False, 0.0, 0.0, 0.0, 0.0
