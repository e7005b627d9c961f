"""From a request to a list of vehicles: which kinds, where each is to stand, and which of them are to do what."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET
from drivegen.core.settings import Count, Positive
from drivegen.placement.where import FARTHEST, Relation, Turn, Wish
from drivegen.words.request import MOST, Density, Group, Kind, Manoeuvre, TrafficRequest

_PLACE = {
    Manoeuvre.HARD_BRAKING: Relation.AHEAD,
    Manoeuvre.STOPPED: Relation.AHEAD,
    Manoeuvre.OVERTAKE: Relation.LEFT_BEHIND,
    Manoeuvre.TURN_LEFT_ACROSS: Relation.ONCOMING,
}
"""Where a vehicle stands for its manoeuvre if it is not said."""

_CUT_IN = {
    Relation.LEFT: Relation.LEFT_AHEAD,
    Relation.RIGHT: Relation.RIGHT_AHEAD,
    Relation.FROM_LEFT: Relation.LEFT_AHEAD,
    Relation.FROM_RIGHT: Relation.RIGHT_AHEAD,
}
_OVERTAKE = {Relation.BEHIND: Relation.LEFT_BEHIND, Relation.LEFT: Relation.LEFT_BEHIND, Relation.RIGHT: Relation.RIGHT_BEHIND}

FASTER = 1.35
"""Who overtakes begins this much faster than everybody else."""

TURNING = 5.5
"""Who turns begins no faster [m/s], unless a speed is asked for: a turn has to be braked for."""

_TURNS = {Manoeuvre.TURN_LEFT: Turn.LEFT, Manoeuvre.TURN_RIGHT: Turn.RIGHT, Manoeuvre.TURN_LEFT_ACROSS: Turn.LEFT}
_THROUGH = {**_TURNS, Manoeuvre.GO_STRAIGHT: Turn.STRAIGHT}

_CALM_BRAKING, _STANDING_ROOM = 1.5, 10.0
"""The target could stop [m/s2] so far [m] before what stands ahead of it, centre to centre."""


@dataclass(frozen=True)
class Fill:
    """A density in numbers: `vehicles` in all where the request does not say how many, within `radius` [m] of the target."""

    vehicles: Count
    radius: Positive


@dataclass(frozen=True)
class Order:
    """What the asked vehicle `number` (0: the target) is to do, `within` [s] of the first frame if that is said."""

    number: int
    manoeuvre: Manoeuvre
    within: float | None


@dataclass(frozen=True)
class Cast:
    """Everybody who is asked for, the target first.

    Attributes:
        kinds: of each, VEHICLE where it is open. wishes: of each. group: which group of the request each belongs to, -1 for
            the target and for those who only fill the road. orders: what some of them are to do.
        radius: within which those without a wish stand [m]; None: as the settings say.
    """

    kinds: tuple[Kind, ...]
    wishes: tuple[Wish, ...]
    group: tuple[int, ...]
    orders: tuple[Order, ...]
    radius: float | None

    def __len__(self) -> int:
        return len(self.kinds)


def cast(
    request: TrafficRequest, densities: Mapping[str, Fill], vehicles: int, random: np.random.Generator, *, left_hand: bool = False
) -> Cast:
    """The vehicles of a request; where it does not say how many there are (`says_how_many`), its density or `vehicles` (in
    all) does.

    Those with a wish come before those without, so that they find their places. In `left_hand` traffic one overtakes on the
    right. Raises UnusableInput for an unknown density.
    """
    fill = _fill(request.density, densities)
    own = Wish(speed=_approach(request), turn=_THROUGH.get(request.target_does) if request.target_does else None)
    kinds, wishes, group = [request.target_kind or Kind.CAR], [own], [-1]
    orders = [Order(TARGET, request.target_does, None)] if request.target_does else []
    ordered = sorted(range(len(request.groups)), key=lambda i: not _wished(request.groups[i]))
    for number in ordered:
        asked = request.groups[number]
        for which in range(asked.count):
            if asked.manoeuvre is not None and which == 0:
                orders.append(Order(len(kinds), asked.manoeuvre, asked.within))
            wishes.append(_wish(asked, which, len(kinds), request.speed, random))
            overtakes = which == 0 and asked.manoeuvre is Manoeuvre.OVERTAKE
            if left_hand and overtakes and asked.place in (None, Relation.BEHIND):
                wishes[-1] = replace(wishes[-1], relation=Relation.RIGHT_BEHIND)
            kinds.append(asked.kind)
            group.append(number)
    if request.density is not Density.NONE and not says_how_many(request):
        more = max((fill.vehicles if fill else vehicles) - len(kinds), 0)
        kinds += [Kind.VEHICLE] * more
        wishes += [Wish(speed=_about(request.speed, random)) for _ in range(more)]
        group += [-1] * more
    return Cast(tuple(kinds), tuple(wishes), tuple(group), tuple(orders), fill.radius if fill else None)


def _fill(density: Density | None, densities: Mapping[str, Fill]) -> Fill | None:
    if density in (None, Density.NONE):
        return None
    if density not in densities:
        raise UnusableInput(f"stages/params.yaml says nothing of the density {density} (asked.settings.densities)")
    fill = densities[density]
    if not 1 <= fill.vehicles <= MOST or fill.radius <= 0:
        raise UnusableInput(f"density {density}: vehicles must lie between 1 and {MOST}, the radius be positive")
    return fill


def _wished(group: Group) -> bool:
    """Whether it says more of its vehicles than their number, kind and speed."""
    return group.place is not None or group.queue or group.manoeuvre is not None


def says_how_many(request: TrafficRequest) -> bool:
    """Whether the number of vehicles is said, beside single ones of which more is said: "ten cars", not "a bus ahead".

    Beside a density, only cars or vehicles of any kind say it: in "heavy traffic with two buses" most are neither.
    """
    heavy = (Kind.TRUCK, Kind.BUS) if request.density is not None else ()
    return any(not _wished(group) and group.kind not in heavy for group in request.groups)


def _wish(group: Group, which: int, number: int, speed: float | None, random: np.random.Generator) -> Wish:
    """Of vehicle `which` of a group, which is the asked vehicle `number`."""
    own = group.speed if group.speed is not None else _about(speed, random)
    if group.queue and which > 0:  # the first of a queue ahead is its last vehicle, so that the target keeps its gap
        return Wish(beside=number - 1, ahead=group.place in (None, Relation.AHEAD), speed=group.speed)
    place, turn = group.place, None
    if which == 0 and group.manoeuvre is not None:
        turn = _THROUGH.get(group.manoeuvre)
        place = _place(group.manoeuvre, place, random)
        if group.manoeuvre is Manoeuvre.STOPPED:
            own = 0.0
        if group.manoeuvre is Manoeuvre.OVERTAKE and group.speed is None and speed is not None:
            own = FASTER * speed
        if group.manoeuvre in _TURNS and own is None:
            own = TURNING
    return Wish(relation=place or (Relation.AHEAD if group.queue else None), distance=group.distance, speed=own, turn=turn)


def _approach(request: TrafficRequest) -> float | None:
    """The target's speed [m/s]: as asked, or one from which it can well stop behind what stands ahead, or turn."""
    still = [group for group in request.groups if group.manoeuvre is Manoeuvre.STOPPED or group.speed == 0]
    standing = [group for group in still if group.place in (None, Relation.AHEAD)]
    if (speed := request.speed if request.target_speed is None else request.target_speed) is not None:
        return speed
    if not standing:
        return TURNING if request.target_does in _TURNS else None
    nearest = min(group.distance or FARTHEST / 2 for group in standing)
    return float(np.sqrt(_CALM_BRAKING * 2 * max(nearest - _STANDING_ROOM, 1.0)))


def _place(manoeuvre: Manoeuvre, place: Relation | None, random: np.random.Generator) -> Relation | None:
    if manoeuvre is Manoeuvre.CUT_IN:
        either = Relation.LEFT_AHEAD if random.random() < 0.5 else Relation.RIGHT_AHEAD
        return either if place is None else _CUT_IN.get(place, place)
    if manoeuvre is Manoeuvre.OVERTAKE and place is not None:
        return _OVERTAKE.get(place, place)
    return place or _PLACE.get(manoeuvre)


def _about(speed: float | None, random: np.random.Generator) -> float | None:
    return None if speed is None else float(speed * random.uniform(0.9, 1.1))
