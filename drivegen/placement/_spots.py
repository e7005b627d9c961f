"""Where the next vehicle may stand and how fast it may drive there: anywhere near, or as was wished; how far off the middle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import TARGET
from drivegen.placement._scene import Scene
from drivegen.placement.draws import Draws
from drivegen.placement.slots import SPACING
from drivegen.placement.where import Wish, standing, standing_to_turn

QUEUE_GAP = (2.0, 8.0)
"""Gap [m], bumper to bumper, to the next in a standing queue ..."""

QUEUE_TIME_GAP = (0.9, 1.6)
"""... and what comes on top [s] while it moves."""

SIMILAR = (0.9, 1.1)
"""Speeds of vehicles at wished places over the target's, where no speed is wished."""


@dataclass(frozen=True)
class Spots:
    """K spots in the order in which they are tried: slot (K,), speed (K,) [m/s], limit (K,) [m/s] of what is allowed."""

    slot: NDArray[np.intp]
    speed: NDArray[np.float64]
    limit: NDArray[np.float64]


def any_spots(
    scene: Scene, fits: NDArray[np.bool_], row: int, spread: float, radius: float, attempts: int, random: np.random.Generator
) -> Spots:
    """As in the paper: anywhere within `radius` [m] that fits, nearer places likelier, at speeds scattered about the target's."""
    slots = scene.slots
    near = ((slots.position - scene.position[TARGET]) ** 2).sum(-1) <= radius**2
    among = np.flatnonzero(fits & near)
    distance = np.hypot(*(slots.position[among] - scene.position[TARGET]).T)
    keys = random.gumbel(size=len(among)) - 2 * distance / radius
    tried = among[np.argsort(-keys, kind="stable")[:attempts]]
    wish, limit = scene.speed[TARGET] * (1 + spread * random.standard_normal(len(tried))), scene.limits(tried, row)
    return Spots(tried, np.clip(wish, 0.0, limit), limit)


def wished_spots(
    scene: Scene, fits: NDArray[np.bool_], row: int, wish: Wish, attempts: int, random: np.random.Generator
) -> Spots:
    """As wished of the vehicle of `row`: in relation to the target, or in a queue behind or ahead of one that was placed."""
    slots = scene.slots
    if wish.beside is None:
        assert wish.relation is not None
        turns = standing_to_turn(slots, scene.slot[TARGET], wish) & fits
        stands = turns if turns.any() else standing(slots, scene.slot[TARGET], wish.relation, wish.distance)
        pace, spread = scene.speed[TARGET], SIMILAR
    elif wish.beside in scene.number:
        next_to = scene.number.index(wish.beside)
        stands, pace, spread = _queued(scene, next_to, row, wish), scene.speed[next_to], (1.0, 1.0)
    else:
        return Spots(np.zeros(0, np.intp), np.zeros(0), np.zeros(0))
    among = np.flatnonzero(fits & stands)
    tried = random.permutation(among)[: 2 * attempts]
    limit = scene.limits(tried, row)
    return Spots(tried, np.minimum(pace * random.uniform(*spread, len(tried)), limit), limit)


def offsets(
    scene: Scene, tried: NDArray[np.intp], row: int, draws: Draws | None, random: np.random.Generator
) -> NDArray[np.float64]:
    """(K,) [m] to the left of the middle of the lane, wholly on it: none without logs to draw it from."""
    if draws is None:
        return np.zeros(len(tried))
    room = (scene.slots.width[scene.slots.lane[tried]] - float(scene.table.size[row, 1])) / 2
    return draws.offsets(room, random)


def _queued(scene: Scene, other: int, row: int, wish: Wish) -> NDArray[np.bool_]:
    """(Q,) slots of the vehicle of `row` next in a queue to the vehicle `other` of the scene."""
    slots = scene.slots
    measure = slots.ways.ahead if wish.ahead else slots.ways.behind
    halves = (float(scene.size[other][0]) + float(scene.table.size[row, 0])) / 2
    away = measure(scene.lane[other], scene.along[other], slots.lane, slots.along) - halves
    speed = scene.speed[other] if wish.speed is None else wish.speed
    low, high = (gap + seconds * speed for gap, seconds in zip(QUEUE_GAP, QUEUE_TIME_GAP, strict=True))
    return np.asarray((away >= low) & (away <= high + SPACING))
