"""Where the next vehicle may stand, and how fast it drives there, as in logs.

It follows somebody who is there already, or leads the foremost, at a gap and a speed seen in logs beside a vehicle of that
speed; or it is the first on its road, as far from a junction as those without a leader are in logs of such traffic.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import TARGET
from drivegen.placement._scene import Scene
from drivegen.placement._spots import Spots
from drivegen.placement.draws import Draws
from drivegen.placement.gaps import Gaps
from drivegen.placement.slots import SPACING
from drivegen.placement.ways import REACH, blocked

FREE = 80.0
"""[m] before a junction from which on it does not matter how far it is."""

NEARLY = 0.1
"""Share of the distance to a junction by which places may differ and are alike."""

FEW = 4
"""Spots that are drawn at first."""

Spot = tuple[int, float] | None
"""A slot and a speed [m/s]; None where what was drawn has no place."""


class Traffic:
    """The growing traffic of one scene, of `count` vehicles in all; the target is there already.

    Nobody stands farther from it than in like traffic, or than in any log where there is no room, or than `radius` [m] if given.
    """

    def __init__(
        self,
        scene: Scene,
        closed: NDArray[np.int32],
        draws: Draws,
        count: int,
        random: np.random.Generator,
        radius: float | None,
    ) -> None:
        slots = scene.slots
        self._scene, self._draws, self._random = scene, draws, random
        self._closed = blocked(slots.ways, closed)[slots.lane]
        self._around = draws.around(count, scene.speed[TARGET], self._limit_at(TARGET), random)
        away = np.hypot(*(slots.position - scene.position[TARGET]).T)
        farthest = draws.farthest if radius is None else radius
        self._near, self._not_far = away <= min(self._around.reach, farthest), away <= farthest
        self._ahead = np.full(len(slots), np.inf)  # [m] to the nearest vehicle ahead of each slot, which is `_leader`
        self._leader = np.full(len(slots), TARGET)
        self._behind = np.full(len(slots), np.inf)
        self._followers: list[Gaps] = []  # of logs, like those of each vehicle
        self._open: list[int] = []  # vehicles that have a leader who is not placed yet

    def spots(self, fits: NDArray[np.bool_], row: int, attempts: int) -> Iterator[Spots]:
        """Spots for a vehicle of `row` among the slots (Q,) on which it fits, group by group until one is taken.

        Few are drawn at first, one by one, as most of them are free. In the last group a vehicle may stand closely ahead of
        another that already follows a third.
        """
        for vehicle in range(len(self._followers), len(self._scene.slot)):
            self._note(vehicle)
        for some in (min(FEW, attempts), max(attempts - FEW, 0)):
            yield self._some(fits & self._near, row, some, crowded=False)
        yield self._some(fits & self._not_far, row, attempts, crowded=True)

    def _some(self, fits: NDArray[np.bool_], row: int, attempts: int, *, crowded: bool) -> Spots:
        free = fits if crowded else fits & (self._behind > REACH)
        first = self._random.random(attempts) >= self._around.share_led
        if not crowded:  # who is the first is harder to place and must not become a follower for that
            first[1:] = first[:1]
        spots = [self._first(free) if one else self._beside(fits, free, row) for one in first.tolist()]
        there = [spot for spot in spots if spot is not None]
        tried, speed = np.array([slot for slot, _ in there], np.intp), np.array([speed for _, speed in there], np.float64)
        limit = self._scene.limits(tried, row)
        return Spots(tried, np.minimum(speed, limit), limit)

    def _note(self, vehicle: int) -> None:
        """Who is the nearest ahead of and behind each slot, now that this vehicle is there."""
        scene, slots = self._scene, self._scene.slots
        slot, place = scene.slot[vehicle], (scene.lane[vehicle], scene.along[vehicle], slots.lane, slots.along)
        back, front = slots.ways.behind(*place), slots.ways.ahead(*place)
        self._open = [other for other in self._open if back[scene.slot[other]] > REACH]
        foremost = self._ahead[slot] > REACH and (vehicle == TARGET or self._behind[slot] <= REACH)
        if foremost and self._random.random() < self._around.share_led:
            self._open.append(vehicle)
        nearer = back < self._ahead
        self._ahead[nearer], self._leader[nearer] = back[nearer], vehicle
        self._behind = np.minimum(self._behind, front)
        self._followers.append(self._draws.followers(scene.speed[vehicle], self._limit_at(vehicle)))

    def _first(self, free: NDArray[np.bool_]) -> Spot:
        first, slots = self._around.first, self._scene.slots
        if not len(first):
            return None
        row_of_log = int(self._random.integers(len(first)))
        to_junction = float(min(first.to_junction[row_of_log], FREE))
        alike = np.abs(np.minimum(slots.to_junction, FREE) - to_junction) <= max(SPACING, NEARLY * to_junction)
        slot = self._one_of(free & alike & (self._closed == first.closed[row_of_log]) & (self._ahead > REACH))
        return None if slot is None else (slot, float(first.pace[row_of_log] * slots.lane_limit[slot]))

    def _beside(self, fits: NDArray[np.bool_], free: NDArray[np.bool_], row: int) -> Spot:
        if self._open and self._random.random() < 1 / len(self._followers):
            return self._before(self._open[int(self._random.integers(len(self._open)))], fits, row)
        return self._after(free, row)

    def _after(self, free: NDArray[np.bool_], row: int) -> Spot:
        """Behind one of those who have room there for what was drawn for them."""
        rows = [int(self._random.integers(len(like))) for like in self._followers]
        gap = np.array([like.gap[k] for like, k in zip(self._followers, rows, strict=True)]) + self._lengths(row)
        fit = free & (np.abs(self._ahead - gap[self._leader]) <= SPACING / 2)
        if not fit.any():
            return None
        leader = int(self._random.choice(np.unique(self._leader[fit])))
        slot = self._one_of(fit & (self._leader == leader))
        return None if slot is None else (slot, float(self._followers[leader].speed[rows[leader]]))

    def _before(self, other: int, fits: NDArray[np.bool_], row: int) -> Spot:
        scene, slots = self._scene, self._scene.slots
        like = self._draws.leaders(scene.speed[other], self._limit_at(other))
        k = int(self._random.integers(len(like)))
        away = slots.ways.ahead(scene.lane[other], scene.along[other], slots.lane, slots.along)
        gap = like.gap[k] + self._lengths(row)[other]
        slot = self._one_of(fits & (np.abs(away - gap) <= SPACING / 2) & (away <= self._behind))
        return None if slot is None else (slot, float(like.leader_speed[k]))

    def _one_of(self, slots: NDArray[np.bool_]) -> int | None:
        among = np.flatnonzero(slots)
        return int(self._random.choice(among)) if len(among) else None

    def _limit_at(self, vehicle: int) -> float:
        return float(self._scene.slots.lane_limit[self._scene.slot[vehicle]])

    def _lengths(self, row: int) -> NDArray[np.float64]:
        """(N,) [m] from the middle of a vehicle of `row` to that of each one placed, if they touch."""
        return (np.stack(self._scene.size)[:, 0] + float(self._scene.table.size[row, 0])) / 2
