"""The vehicles placed so far, and whether another one can stand among them."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivegen.assets.slots import Slots
from drivegen.assets.table import Table
from drivegen.geometry import boxes_overlap

BRAKING = 3.0
"""Deceleration [m/s2] with which a faster follower can still slow down to its leader's speed."""

CLEARANCE = 0.4
"""Boxes are this much longer and wider [m] when tested for overlap."""


@dataclass(frozen=True)
class Bounds:
    """Least gaps between followers and leaders: `time_gap` [s] comes on top of `standstill_gap` [m]."""

    time_gap: float
    standstill_gap: float

    def needed(self, follower: NDArray[np.float64], leader: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K,) gap [m], bumper to bumper: standstill gap, time gap, and room to slow down to the leader's speed."""
        braking = np.maximum(follower**2 - leader**2, 0.0) / (2 * BRAKING)
        return self.standstill_gap + self.time_gap * follower + braking


@dataclass
class Scene:
    """Placed vehicles as growing lists of equal length: slot, speed [m/s], row of the table, number in what was asked."""

    slots: Slots
    table: Table
    bounds: Bounds
    slot: list[int] = field(default_factory=list)
    speed: list[float] = field(default_factory=list)
    row: list[int] = field(default_factory=list)
    number: list[int] = field(default_factory=list)

    def add(self, slot: int, speed: float, row: int, number: int) -> None:
        """Place a vehicle."""
        self.slot.append(slot)
        self.speed.append(speed)
        self.row.append(row)
        self.number.append(number)

    def overlaps(self, tried: NDArray[np.intp], row: int) -> NDArray[np.bool_]:
        """(K,) whether a vehicle of `row` would overlap anyone at each slot tried."""
        slots = self.slots
        hit = boxes_overlap(
            slots.position[tried][:, None],
            slots.heading[tried][:, None],
            self.table.size[row, :2].astype(np.float64) + CLEARANCE,
            slots.position[self.slot],
            slots.heading[self.slot],
            self.table.size[self.row, :2].astype(np.float64),
        )
        return np.asarray(hit.any(-1))

    def keeps_gaps(self, slot: int, speed: float, row: int) -> bool:
        """Whether the gaps to all leaders and followers along the lanes are plausible."""
        lane, along = int(self.slots.lane[slot]), float(self.slots.along[slot])
        placed = np.array(self.slot)
        lanes, alongs, speeds = self.slots.lane[placed], self.slots.along[placed], np.array(self.speed)
        own = np.full(len(speeds), speed)
        length = (self.table.size[self.row, 0] + self.table.size[row, 0]).astype(np.float64) / 2
        ahead = self.slots.ways.ahead(lane, along, lanes, alongs) - length
        if (ahead < self.bounds.needed(own, speeds)).any():
            return False
        behind = self.slots.ways.behind(lane, along, lanes, alongs) - length
        return not (behind < self.bounds.needed(speeds, own)).any()
