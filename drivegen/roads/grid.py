"""Find the lanes near a point: a uniform grid over short pieces of the lanes' centrelines.

Every piece is at most `PIECE` long and filed under the cell of its middle, so one look at the cells within the search
radius plus half a piece finds everything. Built by sorting, a few numpy calls whatever the size of the map.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

PIECE = 4.0
"""No piece of a lane in the grid is longer [m]."""

CELL = 10.0
"""Side of a grid cell [m]; wider where a map is so large that it would have over a million cells."""

MOST_CELLS = 1_000_000
MOST_HITS = 48
"""Lanes that one query reports at most; the nearest ones are kept."""


@dataclass(frozen=True)
class LaneHits:
    """H lanes near one point, nearest first.

    Attributes:
        lane: (H,) int32. s: (H,) float32 [m] along the lane, below 0 or above its length on a straight extension.
        d: (H,) float32 [m] offset of the point to the left of the lane. heading: (H,) float32 [rad] of the lane there.
        distance: (H,) float32 [m], |d| except off the lane's ends.
    """

    lane: NDArray[np.int32]
    s: NDArray[np.float32]
    d: NDArray[np.float32]
    heading: NDArray[np.float32]
    distance: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.lane)


@dataclass(frozen=True)
class SegmentGrid:
    """Pieces of lanes, sorted by the cell of their middle.

    Attributes:
        piece: (S, 4) float32 x, y of both ends [m]. lane: (S,) int32. s: (S,) float32 [m] of the first end.
        origin: (2,) float64 [m] corner of the grid. cell: side [m]. columns, rows: size.
        start: (columns * rows + 1,) int32 first piece of each cell.
    """

    piece: NDArray[np.float32]
    lane: NDArray[np.int32]
    s: NDArray[np.float32]
    origin: NDArray[np.float64]
    cell: float
    columns: int
    rows: int
    start: NDArray[np.int32]

    @classmethod
    def of(cls, piece: NDArray[np.float32], lane: NDArray[np.int32], s: NDArray[np.float32]) -> "SegmentGrid":
        """File the pieces; none may be longer than `PIECE`."""
        if len(piece) == 0:
            nothing = np.zeros(2, np.int32)
            return cls(piece.reshape(0, 4), lane, s, np.zeros(2), CELL, 1, 1, nothing)
        middle = ((piece[:, :2] + piece[:, 2:]) / 2).astype(np.float64)
        low, high = middle.min(0), middle.max(0)
        cell = max(CELL, float(np.sqrt(np.prod(high - low + CELL) / MOST_CELLS)))
        columns, rows = (int(n) for n in np.floor((high - low) / cell).astype(int) + 1)
        place = np.floor((middle - low) / cell).astype(np.int64)
        number = place[:, 1] * columns + place[:, 0]
        order = np.argsort(number, kind="stable")
        start = np.searchsorted(number[order], np.arange(columns * rows + 1)).astype(np.int32)
        return cls(piece[order], lane[order], s[order], low, cell, columns, rows, start)

    @property
    def arrays(self) -> tuple[Any, ...]:
        """Everything that the compiled searches below need, in their order."""
        return self.piece, self.lane, self.s, self.origin, self.cell, self.columns, self.rows, self.start

    def near(self, position: NDArray[np.floating], radius: float) -> LaneHits:
        """All lanes within `radius` [m] of `position` (2,), each once at its nearest point, nearest first."""
        lane, numbers = _near(float(position[0]), float(position[1]), radius, *self.arrays)
        order = np.lexsort((lane, numbers[:, 3]))
        s, d, heading, distance = numbers[order].T.astype(np.float32)
        return LaneHits(lane[order], s, d, heading, distance)

    def nearest(
        self, positions: NDArray[np.floating], headings: NDArray[np.floating], radius: float, max_angle: float
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """For Q poses the nearest lane (Q,) that runs within `max_angle`, -1 if none; and (Q, 4) s, d, heading, distance."""
        poses = np.ascontiguousarray(positions, np.float64), np.ascontiguousarray(headings, np.float64)
        result: tuple[NDArray[np.int32], NDArray[np.float32]] = _nearest(*poses, radius, max_angle, *self.arrays)
        return result


@njit(cache=True)
def _project(x, y, piece):  # type: ignore[no-untyped-def]
    """Share along the piece, offset to the left, heading and distance of the point."""
    ax, ay = float(piece[0]), float(piece[1])
    ex, ey = float(piece[2]) - ax, float(piece[3]) - ay
    length = max(np.sqrt(ex * ex + ey * ey), 1e-9)
    along = min(max(((x - ax) * ex + (y - ay) * ey) / length, 0.0), length)
    gap_x, gap_y = x - ax - along * ex / length, y - ay - along * ey / length
    distance = np.sqrt(gap_x * gap_x + gap_y * gap_y)
    side = 1.0 if ex * gap_y - ey * gap_x >= 0 else -1.0
    return along, side * distance, np.arctan2(ey, ex), distance


@njit(cache=True)
def _window(value, low, cell, count, reach):  # type: ignore[no-untyped-def]
    """First and last cell, along one axis, within `reach` of `value`; beyond the grid the first comes after the last."""
    first = int(np.floor((value - reach - low) / cell))
    last = int(np.floor((value + reach - low) / cell))
    return min(max(first, 0), count), min(last, count - 1)


@njit(cache=True)
def _near(x, y, radius, piece, lane, s, origin, cell, columns, rows, start):  # type: ignore[no-untyped-def]
    lanes = np.empty(MOST_HITS, np.int32)
    numbers = np.empty((MOST_HITS, 4))
    count = 0
    first_x, last_x = _window(x, origin[0], cell, columns, radius + PIECE / 2)
    first_y, last_y = _window(y, origin[1], cell, rows, radius + PIECE / 2)
    for row in range(first_y, last_y + 1):
        for i in range(start[row * columns + first_x], start[row * columns + last_x + 1] if last_x >= first_x else 0):
            along, d, heading, distance = _project(x, y, piece[i])
            if distance > radius:
                continue
            k = 0
            while k < count and lanes[k] != lane[i]:
                k += 1
            if k == count:
                if count < MOST_HITS:
                    count += 1
                else:
                    k = int(np.argmax(numbers[:, 3]))
                    if distance >= numbers[k, 3]:
                        continue
                numbers[k, 3] = np.inf
                lanes[k] = lane[i]
            if distance < numbers[k, 3]:
                numbers[k] = (s[i] + along, d, heading, distance)
    return lanes[:count], numbers[:count]


@njit(cache=True)
def _nearest(positions, headings, radius, max_angle, piece, lane, s, origin, cell, columns, rows, start):  # type: ignore[no-untyped-def]
    count = len(positions)
    best = np.full(count, -1, np.int32)
    numbers = np.full((count, 4), np.inf, np.float32)
    for q in range(count):
        x, y = positions[q]
        closest = radius
        first_x, last_x = _window(x, origin[0], cell, columns, radius + PIECE / 2)
        first_y, last_y = _window(y, origin[1], cell, rows, radius + PIECE / 2)
        for row in range(first_y, last_y + 1):
            for i in range(start[row * columns + first_x], start[row * columns + last_x + 1] if last_x >= first_x else 0):
                along, d, heading, distance = _project(x, y, piece[i])
                turn = abs((heading - headings[q] + np.pi) % (2 * np.pi) - np.pi)
                if distance < closest and turn <= max_angle:
                    closest = distance
                    best[q] = lane[i]
                    numbers[q] = (s[i] + along, d, heading, distance)
    return best, numbers
