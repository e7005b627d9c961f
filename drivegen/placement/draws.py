"""Draws from the vehicles of training logs: how a vehicle beside another is driven, and what traffic around a target is like."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.placement.gaps import SLOW, STANDSTILL, Gaps

SPEEDS, LIMITS, COUNTS = 1.0, 4.0, 4.0
"""Differences of speeds [m/s], of speed limits [m/s] and of numbers of vehicles that count alike when like rows are sought."""


@dataclass(frozen=True)
class Around:
    """What traffic around a target is like.

    Attributes:
        reach: nobody stands farther from the target [m]. share_led: of vehicles with a leader.
        first: Gaps, vehicles without a leader in such traffic; may be none.
    """

    reach: float
    share_led: float
    first: Gaps


class Draws:
    """Draws from the rows of `Gaps`: NEAREST rows with a like speed and limit are equally likely, and LIKE logs.

    Attributes:
        least_gap: [m] that hardly anybody falls short of in a standing queue.
        least_time_gap: [s] that comes on top of it while moving, for all but one in a hundred.
        farthest: [m] from a target that anybody stands.
    """

    NEAREST = 40
    LIKE = 10

    def __init__(self, gaps: Gaps) -> None:
        self._gaps, self._led, self.farthest = gaps, gaps[gaps.led], float(gaps.away.max())
        slow = self._led.speed <= SLOW
        self.least_gap = float(np.quantile(self._led.gap[slow], 0.01)) if slow.any() else STANDSTILL
        headway = (self._led.gap[~slow] - self.least_gap) / self._led.speed[~slow]
        self.least_time_gap = max(float(np.quantile(headway, 0.01)), 0.0) if len(headway) else 0.0
        # a log's first row is its target's, if that is on a lane
        _, first, self._log, self._count = np.unique(gaps.scenario_id, return_index=True, return_inverse=True, return_counts=True)
        self._targets = gaps[first]
        offsets = np.append(0.0, gaps.offset[gaps.to_junction > 0])  # inside junctions corners are cut
        self._offsets = offsets[np.argsort(np.abs(offsets), kind="stable")]

    def around(self, count: int, speed: float, limit: float, random: np.random.Generator) -> Around:
        """Traffic of `count` vehicles around a target of this speed [m/s], where this is the limit [m/s]: one log's of the LIKE.

        The vehicles without a leader are those of all LIKE logs.
        """
        targets = self._targets
        unlike = np.abs(self._count - count) / COUNTS + np.abs(targets.speed - speed) / SPEEDS
        logs = _least(unlike + np.abs(targets.limit - limit) / LIMITS, self.LIKE)
        own = self._gaps[self._log == random.choice(logs)]
        first = self._gaps[np.isin(self._log, logs) & ~self._gaps.led]
        return Around(float(own.away.max()), float(own.led.mean()), first)

    def target_speed(self, limit: float, random: np.random.Generator) -> float:
        """Speed [m/s] of a target where this is the limit [m/s]."""
        row = random.choice(_least(np.abs(self._targets.limit - limit), self.NEAREST))
        return float(self._targets.pace[row]) * limit

    def followers(self, leader_speed: float, limit: float) -> Gaps:
        """Of vehicles behind a leader of this speed [m/s], where this is the limit [m/s]: the likest."""
        return self._like(self._led.leader_speed, leader_speed, limit)

    def leaders(self, speed: float, limit: float) -> Gaps:
        """Of vehicles of this speed [m/s] with a leader, where this is the limit [m/s]: the likest."""
        return self._like(self._led.speed, speed, limit)

    def offsets(self, room: NDArray[np.floating], random: np.random.Generator) -> NDArray[np.float64]:
        """(K,) [m] to the left of the middle of the lane, within `room` (K,) to either side."""
        inside = np.searchsorted(np.abs(self._offsets), np.maximum(room, 0.0), side="right")
        return np.asarray(self._offsets[(random.random(len(room)) * inside).astype(np.intp)])

    def _like(self, speeds: NDArray[np.float32], speed: float, limit: float) -> Gaps:
        unlike = np.abs(speeds - speed) / SPEEDS + np.abs(self._led.limit - limit) / LIMITS
        return self._led[_least(unlike, self.NEAREST)]


def _least(values: NDArray[np.floating], count: int) -> NDArray[np.intp]:
    """The `count` least of the values, all that equal the last of them, and no others."""
    if len(values) <= count:
        return np.arange(len(values))
    return np.flatnonzero(values <= np.partition(values, count - 1)[count - 1])
