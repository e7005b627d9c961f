"""Which vehicles to learn from at which steps, of logs that are too many to list all of them: they are found when asked for."""

import numpy as np
from numpy.typing import NDArray

from drivegen.generators.shared.closed_loop import Crowd, Tracks

CHUNK = 4096
"""Boxes that are counted at once."""


class Moments:
    """`moments[rows]` are boxes (b,) and steps (b,): vehicles seen then and `least` steps later, every `stride` steps.

    `throughout` asks for all steps between, too. `boxes` are those that are looked at, all if none are named. The order is that
    of boxes, then of steps; of more than `most` so many are taken, evenly spread. Of each box only how many it has is kept.
    """

    def __init__(
        self, tracks: Tracks, stride: int, least: int, *, throughout: bool = False,
        boxes: NDArray[np.integer] | None = None, most: int | None = None,
    ) -> None:  # fmt: skip
        self.tracks, self.boxes = tracks, boxes
        self.steps = np.arange(0, max(tracks.valid.shape[1] - least, 0), stride)
        self.seen = range(least + 1) if throughout else (0, least)
        size = len(tracks.valid) if boxes is None else len(boxes)
        chunks = [self._learnable(np.arange(low, min(low + CHUNK, size))).sum(axis=1) for low in range(0, size, CHUNK)]
        self._before = np.concatenate([np.zeros(1, np.int64), *chunks]).cumsum()
        every = int(self._before[-1])
        self._kept = None if most is None or every <= most else np.linspace(0, every - 1, most).astype(np.intp)

    def __len__(self) -> int:
        return int(self._before[-1]) if self._kept is None else len(self._kept)

    def __getitem__(self, rows: NDArray[np.integer]) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
        rows = rows if self._kept is None else self._kept[rows]
        number = np.searchsorted(self._before, rows, side="right") - 1
        before = np.cumsum(self._learnable(number), axis=1)
        step = self.steps[(before <= (rows - self._before[number])[:, None]).sum(axis=1)]
        return number if self.boxes is None else self.boxes[number], step

    def crowds(self, rows: NDArray[np.integer]) -> tuple[Crowd, NDArray[np.int64]]:
        """Everybody in the scene of each of the moments `rows` (b,), a group each, and the box (b,) there that it is of."""
        box, step = self[rows]
        scene = self.tracks.scene(box)
        crowd = self.tracks.at(scene, step)
        return crowd, crowd.start[:-1] + box - self.tracks.start[scene]

    def _learnable(self, number: NDArray[np.integer]) -> NDArray[np.bool_]:
        """(b, steps)."""
        box = number if self.boxes is None else self.boxes[number]
        valid = self.tracks.valid[box]
        seen = np.logical_and.reduce([valid[:, self.steps + k] for k in self.seen])
        return np.asarray(seen & self.tracks.planned[box, None])
