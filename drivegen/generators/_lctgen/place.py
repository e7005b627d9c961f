"""LCTGen's placement: from a scenario code and a map to vehicles on it, by the heads that were trained with the motion."""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap, rotate
from drivegen.core.scenario import TARGET, Scenario, SizeSource, Vehicles
from drivegen.generators._lctgen.learning import SCALES, around_targets
from drivegen.generators._lctgen.net import LctgenNet
from drivegen.generators.shared.vectors import AGENTS, Scenes

ATTEMPTS = 20
"""Draws of a vehicle that would stand on another before it is left out."""

LEAST_SIZE, MOST_SIZE = (2.5, 1.4), (18.0, 2.6)
"""[m] length and width of a placed vehicle are kept within."""

ROOM = 0.5
"""[m] more than its size that a vehicle needs."""


def place(net: LctgenNet, scenario: Scenario, code: NDArray[np.int64], rng: np.random.Generator) -> Vehicles:
    """The scenario's target and one vehicle for each further row of `code` (N, 8), drawn and free of one another.

    The scenario gives map, signals and target; its other vehicles are not looked at. A vehicle that finds no room in
    ATTEMPTS draws is left out. Raises UnusableInput for more than AGENTS vehicles.
    """
    count = len(code)
    if count > AGENTS:
        raise UnusableInput(f"a code of {count} vehicles; LCTGen places {AGENTS} at most")
    scenes = around_targets([scenario])
    scenes.present[0, :count] = True
    padded = np.zeros((1, AGENTS, code.shape[1]), np.int64)
    padded[0, :count] = code
    inputs = scenes.tensors(torch.device("cpu"))
    with torch.inference_mode():
        roads = net.roads(inputs)
        placed = net.placed(net.decoded(inputs, roads, torch.from_numpy(padded), None), roads)
    odds = torch.softmax(placed.piece.masked_fill(~inputs.drawn[:, None], -torch.inf), -1)[0].double().numpy()
    weight = torch.softmax(placed.weight, -1)[0].double().numpy()
    mean, spread = placed.mean[0].numpy(), placed.log_scale.exp()[0].numpy()
    taken = [_row(scenario.vehicles)]
    for n in range(1, count):
        for _ in range(ATTEMPTS):
            piece = _drawn(odds[n], rng)
            part = _drawn(weight[n], rng)
            drawn = (mean[n, part] + spread[n, part] * rng.normal(size=len(SCALES))) * SCALES
            row = _on_map(scenes, piece, drawn)
            if not _overlaps(row, taken):
                taken.append(row)
                break
    return _vehicles(scenario.vehicles, taken)


def _drawn(odds: NDArray[np.float64], rng: np.random.Generator) -> int:
    return int(rng.choice(len(odds), p=odds / odds.sum()))


def _row(vehicles: Vehicles) -> NDArray[np.float64]:
    """The target as x, y, heading, length, width, speed."""
    return np.array(
        [*vehicles.position[TARGET], vehicles.heading[TARGET], *vehicles.size[TARGET, :2], vehicles.speed[TARGET]], np.float64
    )


def _on_map(scenes: Scenes, piece: int, drawn: NDArray[np.float64]) -> NDArray[np.float64]:
    """A vehicle's row in the map's frame from its attributes on a piece of road."""
    points, frame = scenes.points[0, piece].astype(np.float64), scenes.frame[0].astype(np.float64)
    along = points[-1] - points[0]
    heading = np.arctan2(along[1], along[0])
    position = points.mean(axis=0) + rotate(drawn[:2], heading)
    size = np.clip(drawn[3:5], LEAST_SIZE, MOST_SIZE)
    return np.array([*(rotate(position, frame[2]) + frame[:2]), heading + drawn[2] + frame[2], *size, max(drawn[5], 0.0)])


def _overlaps(row: NDArray[np.float64], others: Sequence[NDArray[np.float64]]) -> bool:
    rows = np.stack(others)
    return bool(boxes_overlap(row[:2], row[2], row[3:5] + ROOM, rows[:, :2], rows[:, 2], rows[:, 3:5]).any())


def _vehicles(given: Vehicles, rows: Sequence[NDArray[np.float64]]) -> Vehicles:
    """The given target, and placed vehicles of its kind and height behind it."""
    placed, count = np.stack(rows)[1:].astype(np.float32), len(rows) - 1
    target = given[[TARGET]]
    height = np.repeat(target.size[:, 2:], count, axis=0)
    return Vehicles(
        np.concatenate([target.track_id, np.array([f"placed-{n + 1}" for n in range(count)], np.str_)]),
        np.concatenate([target.kind, np.repeat(target.kind, count)]),
        np.concatenate([target.size, np.concatenate([placed[:, 3:5], height], axis=1)]),
        np.concatenate([target.size_source, np.full(count, SizeSource.ASSUMED, np.uint8)]),
        np.concatenate([target.position, placed[:, :2]]),
        np.concatenate([target.heading, placed[:, 2]]),
        np.concatenate([target.speed, placed[:, 5]]),
    )
