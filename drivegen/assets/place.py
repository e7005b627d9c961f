"""Place vehicles on a map (paper, vehicle assets generation).

The target first, at random in a feasible place, with the lane's heading and a sensible speed; then social vehicles around
it. In mode `paper` they stand anywhere near it and drive about as fast; in mode `data` gaps and speeds are drawn from logs.
Either way nobody overlaps, faces the wrong way or follows at an implausible time gap: what does not fit anywhere is
rejected with a reason, so asked = placed + rejected.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.assets._scene import Bounds, Scene
from drivegen.assets._spots import Spots, any_spots, drawn_spots, wished_spots
from drivegen.assets.gaps import Draws
from drivegen.assets.slots import Slots
from drivegen.assets.table import Provenance, Table
from drivegen.assets.where import Wish, before_turn, standing, standing_to_turn
from drivegen.errors import UnusableInput
from drivegen.roadmap import LaneKind
from drivegen.scenario import SizeSource, VehicleKind, Vehicles
from drivegen.settings import Count, NotNegative, Positive

MODES = ("paper", "data")

_TARGETS = 16
"""Places for the target that are looked at for one from which every wish can be met."""


_FEW = 4
"""Spots drawn from logs at first."""


@dataclass(frozen=True)
class PlaceSettings:
    """How vehicles are placed.

    Attributes:
        mode: `paper`, or `data`: gaps and speeds as in logs.
        road_ahead: the target starts with at least so much road before it [m], or where the map has most.
        radius: social vehicles stand within this distance of the target [m].
        speed_spread: standard deviation of a social vehicle's speed over the target's, as a share of it (mode `paper`).
        least_time_gap: [s] between a vehicle and its leader, standstill_gap [m] comes on top (mode `paper`; in mode `data`
            both are the smallest hundredth of what was seen).
        attempts: places that are tried for one vehicle.
    """

    mode: str
    road_ahead: NotNegative
    radius: Positive
    speed_spread: NotNegative
    least_time_gap: NotNegative
    standstill_gap: NotNegative
    attempts: Count

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise UnusableInput(f"placement: mode is one of {', '.join(MODES)}, not {self.mode!r}")


@dataclass(frozen=True)
class Placement:
    """What was placed and what was not.

    Attributes:
        vehicles: Vehicles (N,), the target first. lane: (N,) int32 the lane of each.
        number: (N,) which of those asked for each vehicle is.
        rejected: how many vehicles were not placed, by the most frequent reason of their attempts: `does-not-fit`
            (no lane that was asked for is long and wide enough), `overlap`, `time-gap`.
    """

    vehicles: Vehicles
    lane: NDArray[np.int32]
    number: NDArray[np.intp]
    rejected: dict[str, int]


def place_vehicles(
    slots: Slots,
    table: Table,
    rows: Sequence[int] | NDArray[np.intp],
    settings: PlaceSettings,
    random: np.random.Generator,
    closed: NDArray[np.int32] | None = None,
    wishes: Sequence[Wish] = (),
    draws: Draws | None = None,
) -> Placement:
    """Place the assets `rows` of the table on the map of `slots`; the first one is the target.

    `closed` names lanes that must not be entered at the first frame (red lights): nobody is too fast to stop there.
    `wishes`, if given, are one for each row: the target's says how fast it drives, the others' where they stand as well.
    `draws` is needed in mode `data`. Raises UnusableInput, reason `no-place`, where the map has no room for the target.
    """
    rows = [int(row) for row in rows]
    wishes = wishes or [Wish()] * len(rows)
    if settings.mode == "data" and draws is None:
        raise UnusableInput("placement in mode data needs the gaps of logs: run the assets stage")
    following = draws if settings.mode == "data" else None
    limit = slots.limit if closed is None or not len(closed) else slots.limit_before(closed)
    bounds = Bounds(settings.least_time_gap, settings.standstill_gap)
    if following is not None:
        bounds = Bounds(following.least_time_gap, following.least_gap)
    scene = Scene(slots, table, bounds)
    target = _target(slots, table, rows[0], settings, wishes, limit, random)
    scene.add(target, _pace(float(limit[target]), wishes[0], following, random), rows[0], 0)
    near = ((slots.position - slots.position[target]) ** 2).sum(-1) <= settings.radius**2
    rejected: Counter[str] = Counter()
    for number, (row, wish) in enumerate(zip(rows[1:], wishes[1:], strict=True), 1):
        fits = fitting(slots, table, row)
        spots: Iterable[Spots]
        if wish.stands:
            spots = [wished_spots(scene, fits, wish, limit, settings.attempts, random)]
        elif following is not None:  # few at first: each is drawn on its own, and most are free
            few = (min(_FEW, settings.attempts), max(settings.attempts - _FEW, 0))
            spots = (drawn_spots(scene, fits & near, limit, following, some, random) for some in few)
        else:
            spots = [any_spots(scene, fits & near, limit, settings.speed_spread, settings.radius, settings.attempts, random)]
        reason = _place_one(scene, spots, wish, row, number)
        if reason is not None:
            rejected[reason] += 1
    return Placement(_vehicles(scene), slots.lane[scene.slot], np.array(scene.number), dict(sorted(rejected.items())))


def fitting(slots: Slots, table: Table, row: int) -> NDArray[np.bool_]:
    """(Q,) slots where the vehicle stands wholly on a lane that is for it."""
    length, width, _ = table.size[row]
    lane = slots.lane
    inside = (slots.along >= length / 2) & (slots.along + length / 2 <= slots.length[lane]) & (slots.width[lane] >= width)
    own = slots.map.kind[lane] == LaneKind.VEHICLE
    if table.kind[row] == VehicleKind.BUS:
        own |= slots.map.kind[lane] == LaneKind.BUS
    return np.asarray(inside & own)


def _target(
    slots: Slots,
    table: Table,
    row: int,
    settings: PlaceSettings,
    wishes: Sequence[Wish],
    limit: NDArray[np.float64],
    random: np.random.Generator,
) -> int:
    """A slot for the target; the first of some drawn from which every wish has a place, where there are wishes."""
    fits = np.flatnonzero(fitting(slots, table, row))
    if not len(fits):
        raise UnusableInput("the map has no lane on which the target fits", reason="no-place")
    feasible = _with_road(slots, fits, settings.road_ahead)
    speed = wishes[0].speed
    if speed is not None and (limit[feasible] >= speed).any():
        feasible = feasible[limit[feasible] >= speed]
    wanted = [wish for wish in wishes[1:] if wish.relation is not None]
    if wishes[0].turn is not None and (turning := feasible[before_turn(slots, wishes[0].turn)[feasible]]).size:
        feasible = turning
    if not wanted:
        return int(random.choice(feasible))
    tried = random.choice(feasible, min(_TARGETS, len(feasible)), replace=False)
    met = [sum(_met(slots, int(slot), wish) for wish in wanted) for slot in tried]
    return int(tried[int(np.argmax(met))])


def _met(slots: Slots, target: int, wish: Wish) -> int:
    """How much of a wish has a place: 2 where it is met in full, 1 where only its turn is missing."""
    assert wish.relation is not None
    if wish.turn is not None and standing_to_turn(slots, target, wish).any():
        return 2
    return int(standing(slots, target, wish.relation, wish.distance).any()) * (1 if wish.turn is not None else 2)


def _with_road(slots: Slots, fits: NDArray[np.intp], wanted: float) -> NDArray[np.intp]:
    """Those of the slots that have the wanted road ahead; the best tenth where none has."""
    road = slots.road_ahead[fits]
    return np.asarray(fits[road >= min(wanted, float(np.quantile(road, 0.9)))])


def _pace(limit: float, wish: Wish, draws: Draws | None, random: np.random.Generator) -> float:
    """The target's speed [m/s]."""
    if wish.speed is not None:
        return min(limit, wish.speed)
    return limit * (random.uniform(0.6, 1.0) if draws is None else min(draws.pace(random), 1.0))


def _place_one(scene: Scene, groups: Iterable[Spots], wish: Wish, row: int, number: int) -> str | None:
    """Add one social vehicle at the first spot that is free and keeps its gaps, or say why none is."""
    reasons: Counter[str] = Counter()
    for spots in groups:
        speed = spots.speed if wish.speed is None else np.minimum(spots.limit, wish.speed)
        free = ~scene.overlaps(spots.slot, row)
        for slot, pace, is_free in zip(spots.slot.tolist(), speed.tolist(), free.tolist(), strict=True):
            if is_free and scene.keeps_gaps(slot, pace, row):
                scene.add(slot, pace, row, number)
                return None
            reasons["time-gap" if is_free else "overlap"] += 1
    return reasons.most_common(1)[0][0] if reasons else "does-not-fit"


def _vehicles(scene: Scene) -> Vehicles:
    slots, table = scene.slots, scene.table
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
