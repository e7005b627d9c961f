"""Place vehicles on a map (paper, vehicle assets generation).

The target first, at random in a feasible place, with the lane's heading and a sensible speed; then social vehicles
around it at similar speed. Nobody overlaps, faces the wrong way or follows at an implausible time gap: what does not fit
anywhere is rejected with a reason, so asked = placed + rejected.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.assets.slots import Slots
from drivegen.assets.table import Provenance, Table
from drivegen.errors import UnusableInput
from drivegen.geometry import boxes_overlap
from drivegen.roadmap import LaneKind
from drivegen.scenario import SizeSource, VehicleKind, Vehicles

_BRAKING = 3.0
"""Deceleration [m/s2] with which a faster follower can still slow down to its leader's speed."""

_CLEARANCE = 0.4
"""Boxes are this much longer and wider [m] when tested for overlap."""


@dataclass(frozen=True)
class PlaceSettings:
    """How vehicles are placed.

    Attributes:
        road_ahead: the target starts with at least so much road before it [m], or where the map has most.
        radius: social vehicles stand within this distance of the target [m].
        speed_spread: standard deviation of a social vehicle's speed over the target's, as a share of it.
        least_time_gap: [s] between a vehicle and its leader, standstill_gap [m] comes on top.
        attempts: places that are tried for one vehicle.
    """

    road_ahead: float
    radius: float
    speed_spread: float
    least_time_gap: float
    standstill_gap: float
    attempts: int


@dataclass(frozen=True)
class Placement:
    """What was placed and what was not.

    Attributes:
        vehicles: Vehicles (N,), the target first. lane: (N,) int32 the lane of each.
        rejected: how many vehicles were not placed, by the most frequent reason of their attempts: `does-not-fit`
            (no lane is long and wide enough), `overlap`, `time-gap`.
    """

    vehicles: Vehicles
    lane: NDArray[np.int32]
    rejected: dict[str, int]


@dataclass
class _Scene:
    """Vehicles placed so far, as growing lists of equal length."""

    slot: list[int]
    speed: list[float]
    row: list[int]


def place_vehicles(
    slots: Slots,
    table: Table,
    rows: Sequence[int] | NDArray[np.intp],
    settings: PlaceSettings,
    random: np.random.Generator,
    closed: NDArray[np.int32] | None = None,
) -> Placement:
    """Place the assets `rows` of the table on the map of `slots`; the first one is the target.

    `closed` names lanes that must not be entered at the first frame (red lights): nobody is too fast to stop there.
    Raises UnusableInput, reason `no-place`, where the map has no room for the target.
    """
    limit = slots.limit if closed is None or not len(closed) else slots.limit_before(closed)
    scene = _Scene([], [], [])
    rejected: Counter[str] = Counter()
    rows = [int(row) for row in rows]
    fits = _fits(slots, table, rows[0])
    if not len(fits):
        raise UnusableInput("the map has no lane on which the target fits", reason="no-place")
    target = int(random.choice(_with_road(slots, fits, settings.road_ahead)))
    pace = float(limit[target] * random.uniform(0.6, 1.0))
    scene.slot, scene.speed, scene.row = [target], [pace], rows[:1]
    near = ((slots.position - slots.position[target]) ** 2).sum(-1) <= settings.radius**2
    for row in rows[1:]:
        reason = _place_one(slots, table, row, near, limit, scene, settings, random)
        if reason is not None:
            rejected[reason] += 1
    return Placement(_vehicles(slots, table, scene), slots.lane[scene.slot], dict(sorted(rejected.items())))


def _with_road(slots: Slots, fits: NDArray[np.intp], wanted: float) -> NDArray[np.intp]:
    """Those of the slots that have the wanted road ahead; the best tenth where none has."""
    road = slots.road_ahead[fits]
    return np.asarray(fits[road >= min(wanted, float(np.quantile(road, 0.9)))])


def _fits(slots: Slots, table: Table, row: int, near: NDArray[np.bool_] | None = None) -> NDArray[np.intp]:
    """Slots where the vehicle stands wholly on a lane that is for it."""
    length, width, _ = table.size[row]
    lane = slots.lane
    inside = (slots.along >= length / 2) & (slots.along + length / 2 <= slots.length[lane]) & (slots.width[lane] >= width)
    own = slots.map.kind[lane] == LaneKind.VEHICLE
    if table.kind[row] == VehicleKind.BUS:
        own |= slots.map.kind[lane] == LaneKind.BUS
    return np.flatnonzero(inside & own if near is None else inside & own & near)


def _place_one(
    slots: Slots,
    table: Table,
    row: int,
    near: NDArray[np.bool_],
    limit: NDArray[np.float64],
    scene: _Scene,
    settings: PlaceSettings,
    random: np.random.Generator,
) -> str | None:
    """Add one social vehicle to the scene, or say why not."""
    fits = _fits(slots, table, row, near)
    if not len(fits):
        return "does-not-fit"
    distance = np.hypot(*(slots.position[fits] - slots.position[scene.slot[0]]).T)
    keys = random.gumbel(size=len(fits)) - 2 * distance / settings.radius  # nearer places are likelier
    tried = fits[np.argsort(-keys, kind="stable")[: settings.attempts]]
    wish = scene.speed[0] * (1 + settings.speed_spread * random.standard_normal(len(tried)))
    speed = np.clip(wish, 0.0, limit[tried])
    free = ~_overlaps(slots, table, tried, row, scene)
    reasons: Counter[str] = Counter()
    for candidate in range(len(tried)):
        if not free[candidate]:
            reasons["overlap"] += 1
        elif not _keeps_gaps(slots, table, int(tried[candidate]), float(speed[candidate]), row, scene, settings):
            reasons["time-gap"] += 1
        else:
            scene.slot.append(int(tried[candidate]))
            scene.speed.append(float(speed[candidate]))
            scene.row.append(row)
            return None
    return reasons.most_common(1)[0][0]


def _overlaps(slots: Slots, table: Table, tried: NDArray[np.intp], row: int, scene: _Scene) -> NDArray[np.bool_]:
    """(K,) whether the vehicle would overlap anyone in the scene at each slot tried."""
    size = table.size[row, :2].astype(np.float64) + _CLEARANCE
    others = table.size[scene.row, :2].astype(np.float64)
    hit = boxes_overlap(
        slots.position[tried][:, None],
        slots.heading[tried][:, None],
        size,
        slots.position[scene.slot],
        slots.heading[scene.slot],
        others,
    )
    return np.asarray(hit.any(-1))


def _keeps_gaps(slots: Slots, table: Table, slot: int, speed: float, row: int, scene: _Scene, settings: PlaceSettings) -> bool:
    """Whether the gaps to all leaders and followers along the lanes are plausible."""
    lane, along = int(slots.lane[slot]), float(slots.along[slot])
    placed = np.array(scene.slot)
    lanes, alongs, speeds = slots.lane[placed], slots.along[placed], np.array(scene.speed)
    length = (table.size[scene.row, 0] + table.size[row, 0]).astype(np.float64) / 2
    ahead = slots.distance_ahead(lane, along, lanes, alongs) - length
    if (ahead < _needed_gap(np.full(len(speeds), speed), speeds, settings)).any():
        return False
    at = np.array([along])
    here = np.array([lane], np.int32)
    behind = np.concatenate([slots.distance_ahead(int(a), float(s), here, at) for a, s in zip(lanes, alongs, strict=True)])
    return not (behind - length < _needed_gap(speeds, np.full(len(speeds), speed), settings)).any()


def _needed_gap(follower: NDArray[np.float64], leader: NDArray[np.float64], settings: PlaceSettings) -> NDArray[np.float64]:
    """(K,) gap [m], bumper to bumper: standstill gap, time gap, and room to slow down to the leader's speed."""
    braking = np.maximum(follower**2 - leader**2, 0.0) / (2 * _BRAKING)
    return settings.standstill_gap + settings.least_time_gap * follower + braking


def _vehicles(slots: Slots, table: Table, scene: _Scene) -> Vehicles:
    measured = table.provenance[scene.row] != Provenance.DOCUMENTED
    return Vehicles(
        track_id=np.array([str(i) for i in range(len(scene.slot))], np.str_),
        kind=table.kind[scene.row],
        size=table.size[scene.row],
        size_source=np.where(measured, SizeSource.MEASURED, SizeSource.ASSUMED).astype(np.uint8),
        position=slots.position[scene.slot].astype(np.float32),
        heading=slots.heading[scene.slot].astype(np.float32),
        speed=np.array(scene.speed, np.float32),
    )
