"""The vehicles placed so far, and whether another one can stand among them."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap, wrap_angle
from drivegen.core.roadmap import NO_LANE, LaneKind
from drivegen.core.scenario import TARGET, SizeSource, VehicleKind, Vehicles
from drivegen.placement.gaps import ALONG_LANE
from drivegen.placement.slots import SPACING, Slots
from drivegen.placement.table import Provenance, Table
from drivegen.roads.graph import LaneGraph

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
    """Placed vehicles as growing lists of equal length, on the slots (Q,) of one map.

    Attributes:
        limit: (Q,) [m/s] the most that who has its front at each slot may drive at the first frame.
        slot: where each stands, or the nearest slot. lane, along: its lane and how far along it [m].
        position: (2,) [m]. heading: [rad]. size: (3,) [m]. speed: [m/s].
        row: of the table, NO_ROW for a target that was given. number: in what was asked. given: that target (1,), if any.
    """

    NO_ROW = -1

    slots: Slots
    table: Table
    bounds: Bounds
    limit: NDArray[np.float64]
    slot: list[int] = field(default_factory=list)
    lane: list[int] = field(default_factory=list)
    along: list[float] = field(default_factory=list)
    position: list[NDArray[np.float64]] = field(default_factory=list)
    heading: list[float] = field(default_factory=list)
    size: list[NDArray[np.float64]] = field(default_factory=list)
    speed: list[float] = field(default_factory=list)
    row: list[int] = field(default_factory=list)
    number: list[int] = field(default_factory=list)
    given: Vehicles | None = None

    def add(self, slot: int, speed: float, row: int, number: int, offset: float = 0.0) -> None:
        """Place a vehicle, `offset` [m] to the left of the middle of its lane."""
        at = np.array([slot], np.intp)
        place = self.places(at, np.array([offset]))[0]
        size = self.table.size[row].astype(np.float64)
        self._append(slot, int(self.slots.lane[slot]), float(self.slots.along[slot]), place, size, speed, row, number)
        self.heading.append(float(self.slots.heading[slot]))

    def add_given(self, target: Vehicles) -> None:
        """Take a target (1,) that stands there already as number 0. Raises UnusableInput, reason `no-place`, off all lanes."""
        self.given = target
        place, heading = target.position[TARGET].astype(np.float64), float(target.heading[TARGET])
        lane, numbers = LaneGraph.of(self.slots.map).nearest(place[None], target.heading[:1], max_angle=np.pi / 2)
        away = np.hypot(*(self.slots.position - place).T)
        away[np.abs(wrap_angle(self.slots.heading - heading)) > ALONG_LANE] += 1e3
        if lane[0] == NO_LANE or not len(away):
            raise UnusableInput("the given target is on no lane", reason="no-place")
        size, speed = target.size[TARGET].astype(np.float64), float(target.speed[TARGET])
        self._append(int(np.argmin(away)), int(lane[0]), float(numbers[0, 0]), place, size, speed, self.NO_ROW, 0)
        self.heading.append(heading)

    def _append(
        self,
        slot: int,
        lane: int,
        along: float,
        place: NDArray[np.float64],
        size: NDArray[np.float64],
        speed: float,
        row: int,
        number: int,
    ) -> None:
        self.slot.append(slot)
        self.lane.append(lane)
        self.along.append(along)
        self.position.append(place)
        self.size.append(size)
        self.speed.append(speed)
        self.row.append(row)
        self.number.append(number)

    def limits(self, slots: NDArray[np.intp], row: int) -> NDArray[np.float64]:
        """(K,) [m/s] the most that a vehicle of `row` may drive on `slots` (K,): that of where its front is."""
        front = slots + int(np.ceil(float(self.table.size[row, 0]) / 2 / SPACING))
        last = np.searchsorted(self.slots.lane, self.slots.lane[slots], side="right") - 1  # slots are sorted by lane
        return self.limit[np.minimum(front, last)]

    def fitting(self, row: int) -> NDArray[np.bool_]:
        """(Q,) slots where a vehicle of `row` stands wholly on a lane that is for it."""
        slots, lane = self.slots, self.slots.lane
        length, width, _ = self.table.size[row]
        inside = (slots.along >= length / 2) & (slots.along + length / 2 <= slots.length[lane]) & (slots.width[lane] >= width)
        own = slots.map.kind[lane] == LaneKind.VEHICLE
        if self.table.kind[row] == VehicleKind.BUS:
            own |= slots.map.kind[lane] == LaneKind.BUS
        return np.asarray(inside & own)

    def places(self, tried: NDArray[np.intp], offset: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K, 2) [m] `offset` (K,) to the left of the slots `tried` (K,)."""
        heading = self.slots.heading[tried]
        return np.asarray(self.slots.position[tried] + offset[:, None] * np.column_stack([-np.sin(heading), np.cos(heading)]))

    def overlaps(self, tried: NDArray[np.intp], offset: NDArray[np.float64], row: int) -> NDArray[np.bool_]:
        """(K,) whether a vehicle of `row` would overlap anyone at each slot tried, `offset` (K,) [m] to its left."""
        hit = boxes_overlap(
            self.places(tried, offset)[:, None],
            self.slots.heading[tried][:, None],
            self.table.size[row, :2].astype(np.float64) + CLEARANCE,
            np.stack(self.position),
            np.array(self.heading),
            np.stack(self.size)[:, :2],
        )
        return np.asarray(hit.any(-1))

    def keeps_gaps(self, slot: int, speed: float, row: int) -> bool:
        """Whether the gaps to all leaders and followers along the lanes are plausible."""
        lane, along = int(self.slots.lane[slot]), float(self.slots.along[slot])
        lanes, alongs, speeds = np.array(self.lane, np.int32), np.array(self.along), np.array(self.speed)
        own = np.full(len(speeds), speed)
        length = (np.stack(self.size)[:, 0] + float(self.table.size[row, 0])) / 2
        ahead = self.slots.ways.ahead(lane, along, lanes, alongs) - length
        if (ahead < self.bounds.needed(own, speeds)).any():
            return False
        behind = self.slots.ways.behind(lane, along, lanes, alongs) - length
        return not (behind < self.bounds.needed(speeds, own)).any()

    def vehicles(self) -> Vehicles:
        """All that were placed, in this order."""
        row = np.array(self.row)
        measured = self.table.provenance[row] != Provenance.DOCUMENTED
        vehicles = Vehicles(
            track_id=np.array([str(i) for i in range(len(row))], np.str_),
            kind=self.table.kind[row],
            size=np.stack(self.size).astype(np.float32),
            size_source=np.where(measured, SizeSource.MEASURED, SizeSource.ASSUMED).astype(np.uint8),
            position=np.stack(self.position).astype(np.float32),
            heading=np.array(self.heading, np.float32),
            speed=np.array(self.speed, np.float32),
        )
        if self.given is not None:
            vehicles.kind[TARGET], vehicles.size_source[TARGET] = self.given.kind[TARGET], self.given.size_source[TARGET]
        return vehicles
