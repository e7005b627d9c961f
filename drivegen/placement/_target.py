"""The target is placed first: on a road that goes on, where every wish of the others can be met, at a sensible speed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.placement._scene import Scene
from drivegen.placement._spots import offsets
from drivegen.placement.draws import Draws
from drivegen.placement.slots import Slots
from drivegen.placement.where import Wish, before_turn, standing, standing_to_turn

_TARGETS = 16
"""Places for the target that are looked at for one from which every wish can be met."""


def add_target(
    scene: Scene, row: int, wishes: Sequence[Wish], road_ahead: float, draws: Draws | None, random: np.random.Generator
) -> None:
    """Place a target of the table's `row`, with `road_ahead` [m] before it if the map has that anywhere.

    The first wish is its own. Raises UnusableInput, reason `no-place`, where it fits on no lane.
    """
    slot = _slot(scene, row, wishes, road_ahead, random)
    offset = offsets(scene, np.array([slot]), row, draws, random)
    scene.add(slot, _speed(scene, slot, row, wishes[0], draws, random), row, 0, float(offset[0]))


def _slot(scene: Scene, row: int, wishes: Sequence[Wish], road_ahead: float, random: np.random.Generator) -> int:
    """One at random; the first of some drawn from which every wish has a place, where there are wishes."""
    feasible = _feasible(scene, row, wishes[0], road_ahead)
    related = [wish for wish in wishes[1:] if wish.relation is not None]
    if not related:
        return int(random.choice(feasible))
    tried = random.choice(feasible, min(_TARGETS, len(feasible)), replace=False)
    met = [sum(_met(scene.slots, int(slot), wish) for wish in related) for slot in tried]
    return int(tried[int(np.argmax(met))])


def _feasible(scene: Scene, row: int, own: Wish, road_ahead: float) -> NDArray[np.intp]:
    """Slots with road ahead on which the target fits; of those the ones where its own wish can be met, if there are any."""
    slots = scene.slots
    fits = np.flatnonzero(scene.fitting(row))
    if not len(fits):
        raise UnusableInput("the map has no lane on which the target fits", reason="no-place")
    feasible = _with_road(slots, fits, road_ahead)
    if own.speed is not None and (fast := scene.limits(feasible, row) >= own.speed).any():
        feasible = feasible[fast]
    if own.turn is not None and (turning := feasible[before_turn(slots, own.turn)[feasible]]).size:
        feasible = turning
    return feasible


def _with_road(slots: Slots, fits: NDArray[np.intp], road_ahead: float) -> NDArray[np.intp]:
    """Those of the slots that have the wanted road ahead; the best tenth where none has."""
    road = slots.road_ahead[fits]
    return np.asarray(fits[road >= min(road_ahead, float(np.quantile(road, 0.9)))])


def _met(slots: Slots, target: int, wish: Wish) -> int:
    """How much of a wish has a place: 2 where it is met in full, 1 where only its turn is missing."""
    assert wish.relation is not None
    if wish.turn is not None and standing_to_turn(slots, target, wish).any():
        return 2
    return int(standing(slots, target, wish.relation, wish.distance).any()) * (1 if wish.turn is not None else 2)


def _speed(scene: Scene, slot: int, row: int, wish: Wish, draws: Draws | None, random: np.random.Generator) -> float:
    """[m/s] as wished or as in logs, as far as the road allows."""
    most = float(scene.limits(np.array([slot]), row)[0])
    if wish.speed is not None:
        return min(most, wish.speed)
    if draws is None:
        return most * random.uniform(0.6, 1.0)
    return min(most, draws.target_speed(float(scene.slots.lane_limit[slot]), random))
