"""Place vehicles on a map (paper, vehicle assets generation).

The target first, at random in a feasible place, with the lane's heading and a sensible speed; then social vehicles around
it. In mode `paper` they stand anywhere near it and drive about as fast; in mode `data` distances, gaps, speeds and offsets to
the middle of the lane are drawn from logs.
Either way nobody overlaps, faces the wrong way or follows at an implausible time gap: what does not fit anywhere is
rejected with a reason, so asked = placed + rejected.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET, Vehicles
from drivegen.core.settings import Count, NotNegative, Positive
from drivegen.placement._scene import Bounds, Scene
from drivegen.placement._spots import Spots, any_spots, offsets, wished_spots
from drivegen.placement._target import add_target
from drivegen.placement._traffic import Traffic
from drivegen.placement.draws import Draws
from drivegen.placement.slots import Slots
from drivegen.placement.table import Table
from drivegen.placement.where import Relation, Wish, in_between

MODES = ("paper", "data")


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


class Placer:
    """Places assets of a table on the map of `slots`; `draws` is needed in mode `data`."""

    def __init__(self, slots: Slots, table: Table, settings: PlaceSettings, draws: Draws | None = None) -> None:
        if settings.mode == "data" and draws is None:
            raise UnusableInput("placement in mode data needs the gaps of logs: run the assets stage")
        self._slots, self._table, self._settings = slots, table, settings
        self._draws = draws if settings.mode == "data" else None

    def place(
        self,
        rows: Sequence[int] | NDArray[np.intp],
        random: np.random.Generator,
        closed: NDArray[np.int32] | None = None,
        wishes: Sequence[Wish] = (),
        target: Vehicles | None = None,
        radius: float | None = None,
    ) -> Placement:
        """Place the assets `rows` of the table; the first one is the target.

        `closed` names lanes that must not be entered at the first frame (red lights): nobody is too fast to stop there.
        `wishes`, if given, are one for each row: the target's says how fast it drives, the others' where they stand as well.
        `target` (1,), if given, stands there already, and the first row is not looked at.
        `radius` [m], if given, is how far from the target the others without a wish stand at most, in either mode.
        Raises UnusableInput, reason `no-place`, where the map has no room for the target.
        """
        closed = np.zeros(0, np.int32) if closed is None else closed
        wishes = wishes or [Wish()] * len(rows)
        scene = self._empty(closed)
        if target is not None:
            scene.add_given(target)
        else:
            add_target(scene, int(rows[0]), wishes, self._settings.road_ahead, self._draws, random)
        traffic = None if self._draws is None else Traffic(scene, closed, self._draws, len(rows), random, radius)
        others = _Others(scene, self._settings, self._draws, traffic, radius, random, np.zeros(len(self._slots), np.bool_))
        rejected: Counter[str] = Counter()
        for number, (row, wish) in enumerate(zip(rows[1:], wishes[1:], strict=True), 1):
            reason = others.add(number, int(row), wish)
            if reason is not None:
                rejected[reason] += 1
        lanes = np.array(scene.lane, np.int32)
        return Placement(scene.vehicles(), lanes, np.array(scene.number), dict(sorted(rejected.items())))

    def _empty(self, closed: NDArray[np.int32]) -> Scene:
        """The map before anybody is there, its least gaps those of the logs or of the settings."""
        settings, slots, draws = self._settings, self._slots, self._draws
        limit = slots.limit_before(closed) if len(closed) else slots.limit
        if draws is None:
            return Scene(slots, self._table, Bounds(settings.least_time_gap, settings.standstill_gap), limit)
        return Scene(slots, self._table, Bounds(draws.least_time_gap, draws.least_gap), limit)


@dataclass(frozen=True)
class _Others:
    """The social vehicles of one scene, which are added one after another; `draws` and `traffic` in mode `data` alone.

    `between` (Q,) are slots for those with a wish alone: whoever was wished ahead of or behind the target is the next to it.
    """

    scene: Scene
    settings: PlaceSettings
    draws: Draws | None
    traffic: Traffic | None
    radius: float | None
    random: np.random.Generator
    between: NDArray[np.bool_]

    def add(self, number: int, row: int, wish: Wish) -> str | None:
        """Add vehicle `number` at the first spot that is free and keeps its gaps, or say why none is."""
        scene = self.scene
        reasons: Counter[str] = Counter()
        for spots in self._spots(row, wish):
            speed = spots.speed if wish.speed is None else np.minimum(spots.limit, wish.speed)
            offset = offsets(scene, spots.slot, row, self.draws, self.random)
            free = ~scene.overlaps(spots.slot, offset, row)
            for k, slot in enumerate(spots.slot.tolist()):
                if free[k] and scene.keeps_gaps(slot, float(speed[k]), row):
                    scene.add(slot, float(speed[k]), row, number, float(offset[k]))
                    if wish.relation in (Relation.AHEAD, Relation.BEHIND) and not wish.anywhere:
                        self.between[:] |= in_between(scene.slots, scene.slot[TARGET], slot, wish.relation)
                    return None
                reasons["time-gap" if free[k] else "overlap"] += 1
        return reasons.most_common(1)[0][0] if reasons else "does-not-fit"

    def _spots(self, row: int, wish: Wish) -> Iterator[Spots]:
        """Where it may stand, group by group: as wished, as in logs, or anywhere near."""
        settings, fits = self.settings, self.scene.fitting(row)
        if wish.stands:
            yield wished_spots(self.scene, fits, row, wish, settings.attempts, self.random)
        if wish.stands and not wish.anywhere:
            return
        fits = fits & ~self.between
        if self.traffic is not None:
            yield from self.traffic.spots(fits, row, settings.attempts)
            return
        radius = settings.radius if self.radius is None else self.radius
        yield any_spots(self.scene, fits, row, settings.speed_spread, radius, settings.attempts, self.random)
