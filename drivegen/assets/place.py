"""Place vehicles on a map (paper, vehicle assets generation).

The target first, at random in a feasible place, with the lane's heading and a sensible speed; then social vehicles around
it. In mode `paper` they stand anywhere near it and drive about as fast; in mode `data` distances, gaps, speeds and offsets to
the middle of the lane are drawn from logs.
Either way nobody overlaps, faces the wrong way or follows at an implausible time gap: what does not fit anywhere is
rejected with a reason, so asked = placed + rejected.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.assets._scene import Bounds, Scene
from drivegen.assets._spots import Spots, any_spots, wished_spots
from drivegen.assets._traffic import Traffic
from drivegen.assets.draws import Draws
from drivegen.assets.slots import Slots
from drivegen.assets.table import Table
from drivegen.assets.where import Wish, before_turn, standing, standing_to_turn
from drivegen.errors import UnusableInput
from drivegen.roadmap import LaneKind
from drivegen.scenario import TARGET, VehicleKind, Vehicles
from drivegen.settings import Count, NotNegative, Positive

MODES = ("paper", "data")

_TARGETS = 16
"""Places for the target that are looked at for one from which every wish can be met."""


@dataclass(frozen=True)
class PlaceSettings:
    """How vehicles are placed.

    Attributes:
        mode: `paper`, or `data`: gaps and speeds as in logs.
        road_ahead: the target starts with at least so much road before it [m], or where the map has most.
        radius: social vehicles stand within this distance of the target [m] (mode `paper`; in mode `data` as far as in logs).
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
            (no lane that was asked for is long and wide enough, or none is like those where logs have anybody), `overlap`,
            `time-gap`.
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
    target: Vehicles | None = None,
    radius: float | None = None,
) -> Placement:
    """Place the assets `rows` of the table on the map of `slots`; the first one is the target.

    `closed` names lanes that must not be entered at the first frame (red lights): nobody is too fast to stop there.
    `wishes`, if given, are one for each row: the target's says how fast it drives, the others' where they stand as well.
    `draws` is needed in mode `data`. `target` (1,), if given, stands there already, and the first row is not looked at.
    `radius` [m], if given, is how far from the target the others without a wish stand at most, in either mode.
    Raises UnusableInput, reason `no-place`, where the map has no room for the target.
    """
    rows = [int(row) for row in rows]
    wishes = wishes or [Wish()] * len(rows)
    if settings.mode == "data" and draws is None:
        raise UnusableInput("placement in mode data needs the gaps of logs: run the assets stage")
    following = draws if settings.mode == "data" else None
    shut = np.zeros(0, np.int32) if closed is None else closed
    limit = slots.limit_before(shut) if len(shut) else slots.limit
    bounds = Bounds(settings.least_time_gap, settings.standstill_gap)
    if following is not None:
        bounds = Bounds(following.least_time_gap, following.least_gap)
    scene = Scene(slots, table, bounds)
    if target is not None:
        scene.add_given(target)
    else:
        slot = _target(slots, table, rows[0], settings, wishes, limit, random)
        offset = _offsets(scene, np.array([slot]), rows[0], following, random)
        scene.add(slot, _pace(scene, slot, limit, wishes[0], following, random), rows[0], 0, float(offset[0]))
    traffic = None if following is None else Traffic(scene, limit, shut, following, len(rows), random, radius)
    within = settings.radius if radius is None else radius
    near = ((slots.position - scene.position[TARGET]) ** 2).sum(-1) <= within**2
    rejected: Counter[str] = Counter()
    for number, (row, wish) in enumerate(zip(rows[1:], wishes[1:], strict=True), 1):
        fits = fitting(slots, table, row)
        spots: Iterable[Spots]
        if wish.stands:
            spots = [wished_spots(scene, fits, wish, limit, settings.attempts, random)]
        elif traffic is not None:
            spots = traffic.spots(fits, row, settings.attempts)
        else:
            spots = [any_spots(scene, fits & near, limit, settings.speed_spread, within, settings.attempts, random)]
        reason = _place_one(scene, spots, wish, row, number, following, random)
        if reason is not None:
            rejected[reason] += 1
    lanes = np.array(scene.lane, np.int32)
    return Placement(scene.vehicles(), lanes, np.array(scene.number), dict(sorted(rejected.items())))


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


def _pace(
    scene: Scene, slot: int, limit: NDArray[np.float64], wish: Wish, draws: Draws | None, random: np.random.Generator
) -> float:
    """The target's speed [m/s]."""
    most = float(limit[slot])
    if wish.speed is not None:
        return min(most, wish.speed)
    if draws is None:
        return most * random.uniform(0.6, 1.0)
    return min(most, draws.target_speed(float(scene.slots.lane_limit[slot]), random))


def _offsets(
    scene: Scene, tried: NDArray[np.intp], row: int, draws: Draws | None, random: np.random.Generator
) -> NDArray[np.float64]:
    """(K,) [m] to the left of the middle of the lane, wholly on it: none without logs to draw it from."""
    if draws is None:
        return np.zeros(len(tried))
    room = (scene.slots.width[scene.slots.lane[tried]] - float(scene.table.size[row, 1])) / 2
    return draws.offsets(room, random)


def _place_one(
    scene: Scene,
    groups: Iterable[Spots],
    wish: Wish,
    row: int,
    number: int,
    draws: Draws | None,
    random: np.random.Generator,
) -> str | None:
    """Add one social vehicle at the first spot that is free and keeps its gaps, or say why none is."""
    reasons: Counter[str] = Counter()
    for spots in groups:
        speed = spots.speed if wish.speed is None else np.minimum(spots.limit, wish.speed)
        offset = _offsets(scene, spots.slot, row, draws, random)
        free = ~scene.overlaps(spots.slot, offset, row)
        for k, slot in enumerate(spots.slot.tolist()):
            if free[k] and scene.keeps_gaps(slot, float(speed[k]), row):
                scene.add(slot, float(speed[k]), row, number, float(offset[k]))
                return None
            reasons["time-gap" if free[k] else "overlap"] += 1
    return reasons.most_common(1)[0][0] if reasons else "does-not-fit"
