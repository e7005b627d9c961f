"""Places beside the target: which slots are ahead of it, behind it, in the lane to its left, oncoming, and so on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import to_vehicle_frame, wrap_angle
from drivegen.core.relation import Relation as Relation
from drivegen.placement.slots import Slots
from drivegen.placement.ways import Turn as Turn

NEAREST, FARTHEST = 4.0, 80.0
"""Distance along the road [m], centre to centre, at which a vehicle is "ahead" or "behind" where no distance is said."""

BESIDE = 12.0
"""Who is in the lane beside the target is within this distance along the road [m] where none is said."""

TOLERANCE = 5.0
"""A distance that is said is met within this [m], or within TOLERANCE_SHARE of it if that is more."""

TOLERANCE_SHARE = 0.2

ALIKE = np.deg2rad(45)
"""Directions that differ by less are the same way; oncoming ones differ from the opposite by less."""

_LANE = (2.0, 5.5)
"""A lane beside another is this far to its side [m]."""

_NEXT = 4.0
"""Who is beside a way is no farther along it than this [m] from where somebody can stand on it."""

_OPPOSITE_SIDE = 40.0
"""Oncoming vehicles are at most this far to the side of the target's heading [m]."""


TURN_BEGINS = (6.0, 28.0)
"""Who is to go through a junction stands so far [m] before it: near enough to be through within the scenario."""

_BETWEEN = 8.0
"""An oncoming vehicle that turns across the target's way does so this far [m] before the target at least."""


@dataclass(frozen=True)
class Wish:
    """What is wished of one vehicle that is to be placed; nothing by default.

    Attributes:
        relation: where it stands as seen from the target. distance: how far along the road, centre to centre [m].
        beside: it stands next in a queue to the vehicle of this number: behind it, or `ahead` of it; then it has no relation.
        speed: at the first frame [m/s], as far as the road allows.
        turn: it stands where its lane soon leads so through a junction, if any of the places wished for is such.
        anywhere: where there is no such place, or none is free, it stands as if nothing were wished.
    """

    relation: Relation | None = None
    distance: float | None = None
    beside: int | None = None
    ahead: bool = False
    speed: float | None = None
    turn: Turn | None = None
    anywhere: bool = False

    @property
    def stands(self) -> bool:
        """Whether it is wished where the vehicle stands."""
        return self.relation is not None or self.beside is not None


def before_turn(slots: Slots, turn: Turn) -> NDArray[np.bool_]:
    """(Q,) which slots lie just before a junction through which their lane leads to the left, to the right or straight on."""
    away = slots.to_turn[:, list(Turn).index(turn)]
    return np.asarray((away >= TURN_BEGINS[0]) & (away <= TURN_BEGINS[1]))


def standing_to_turn(slots: Slots, target: int, wish: Wish) -> NDArray[np.bool_]:
    """(Q,) which slots stand as wished in relation to the slot `target` and just before the wished turn, if any.

    Who comes towards the target and turns left does so at a junction between the two.
    """
    assert wish.relation is not None
    stands = standing(slots, target, wish.relation, wish.distance)
    if wish.turn is None:
        return stands
    stands = stands & before_turn(slots, wish.turn)
    if wish.relation is Relation.ONCOMING and wish.turn is Turn.LEFT:
        x = to_vehicle_frame(slots.position, slots.position[target], slots.heading[target])[:, 0]
        stands = stands & (x > slots.to_turn[:, 0] + _BETWEEN)
    return np.asarray(stands)


def standing(slots: Slots, target: int, relation: Relation, distance: float | None) -> NDArray[np.bool_]:
    """(Q,) which slots stand in `relation` to the slot `target`, `distance` [m] along the road away if that is given."""
    if relation in (Relation.AHEAD, Relation.BEHIND):
        along = _driving_distance(slots, target, ahead=relation is Relation.AHEAD)
        return _within(along, NEAREST, FARTHEST, distance)
    x, y = to_vehicle_frame(slots.position, slots.position[target], slots.heading[target]).T
    turn = wrap_angle(slots.heading - slots.heading[target])
    if relation is Relation.ONCOMING:
        return np.asarray((np.abs(turn) > np.pi - ALIKE) & (np.abs(y) < _OPPOSITE_SIDE) & _within(x, NEAREST, FARTHEST, distance))
    if relation in (Relation.FROM_LEFT, Relation.FROM_RIGHT):
        side = 1.0 if relation is Relation.FROM_LEFT else -1.0
        across = np.abs(turn + side * np.pi / 2) < ALIKE
        return np.asarray(across & (side * y > NEAREST) & (side * y < FARTHEST) & (x > 0) & _within(x, 0.0, FARTHEST, distance))
    side = 1.0 if relation.value.startswith("left") else -1.0
    reach = max(FARTHEST / 2, (1 + TOLERANCE_SHARE) * (distance or 0.0) + TOLERANCE) + _NEXT
    along, aside = _beside_way(slots, target, reach)
    beside = (side * aside > _LANE[0]) & (side * aside < _LANE[1]) & (slots.lane != slots.lane[target])
    if relation.value.endswith("ahead"):
        return np.asarray(beside & _within(along, NEAREST, FARTHEST / 2, distance))
    if relation.value.endswith("behind"):
        return np.asarray(beside & _within(-along, NEAREST, FARTHEST / 2, distance))
    return np.asarray(beside & (_within(np.abs(along), 0.0, BESIDE, distance)))


def _beside_way(slots: Slots, target: int, reach: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How far along the way of the slot `target` each slot is (Q,) [m], below 0 behind it, and how far to its left (Q,) [m].

    The way leads through the target's lane without lane changes. Both are measured at the way's nearest slot of about the
    same heading, so a bend turns neither of them; NaN for slots that lie nowhere along it within `reach` [m].
    """
    along, aside = np.full((2, len(slots)), np.nan)
    ahead, behind = (_driving_distance(slots, target, ahead=forward) for forward in (True, False))
    driven = np.where(np.isfinite(ahead), ahead, -behind)
    way = np.flatnonzero(np.abs(driven) <= reach)
    near = np.flatnonzero(((slots.position - slots.position[target]) ** 2).sum(-1) <= (reach + _LANE[1]) ** 2)
    alike = np.abs(wrap_angle(slots.heading[near, None] - slots.heading[way])) < ALIKE
    away = np.where(alike, ((slots.position[near, None] - slots.position[way]) ** 2).sum(-1), np.inf)
    next_to = way[np.argmin(away, axis=1)]
    gap, cos, sin = slots.position[near] - slots.position[next_to], np.cos(slots.heading[next_to]), np.sin(slots.heading[next_to])
    further = gap[:, 0] * cos + gap[:, 1] * sin
    there = alike.any(axis=1) & (np.abs(further) < _NEXT)
    along[near[there]] = (driven[next_to] + further)[there]
    aside[near[there]] = (gap[:, 1] * cos - gap[:, 0] * sin)[there]
    return along, aside


def in_between(slots: Slots, target: int, other: int, relation: Relation) -> NDArray[np.bool_]:
    """(Q,) which slots lie between the slot `target` and the slot `other`, which is AHEAD or BEHIND on its way."""
    forward, back = (slots.ways.ahead, slots.ways.behind) if relation is Relation.AHEAD else (slots.ways.behind, slots.ways.ahead)
    from_target = forward(int(slots.lane[target]), float(slots.along[target]), slots.lane, slots.along)
    to_other = back(int(slots.lane[other]), float(slots.along[other]), slots.lane, slots.along)
    return np.asarray((from_target < from_target[other]) & np.isfinite(to_other))


def _within(along: NDArray[np.floating], low: float, high: float, distance: float | None) -> NDArray[np.bool_]:
    if distance is None:
        return np.asarray((along >= low) & (along <= high))
    return np.asarray(np.abs(along - distance) <= max(TOLERANCE, TOLERANCE_SHARE * distance))


def _driving_distance(slots: Slots, target: int, *, ahead: bool) -> NDArray[np.float64]:
    """(Q,) [m] of driving from the target to each slot, or from each slot to the target; inf where there is no such way."""
    measure = slots.ways.ahead if ahead else slots.ways.behind
    return measure(int(slots.lane[target]), float(slots.along[target]), slots.lane, slots.along)
