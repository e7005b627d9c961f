"""LCTGen's map code, and retrieval of a map from a library by it (paper, sections 4.1 and 4.3).

Six numbers as the target sees them: lanes that run its way, lanes the other way, lanes that cross to the left and to the right,
distance to the nearest junction ahead, and which lane from the left it is on. A map is retrieved where the code is nearest; if
several are, one of them is drawn.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import line_heading, resample, rotate, wrap_angle
from drivegen.core.roadmap import RoadMap

FIELDS = ("same", "opposite", "left", "right", "to_junction", "lane")

MOST_LANES = 6
"""Lanes of one kind are counted up to this number."""

ROAD, CROSSING = 25.0, 60.0
"""[m] Lanes within the one are of the target's road, those that cross are looked for within the other."""

JUNCTION, JUNCTIONS = 5.0, 20
"""[m] of a bin of the distance to a junction and number of bins; the last stands for farther or none."""

STEP = 4.0
"""[m] between the points of lanes that are looked at."""

WEIGHTS = np.array([3.0, 3.0, 1.0, 1.0, 0.5, 1.0])
"""Of a difference of one in each field: the number of lanes counts most."""


def map_code(roads: RoadMap, position: NDArray[np.floating], heading: float) -> NDArray[np.int64]:
    """(6,) the code of `roads` for a target at `position` (2,) [m] facing `heading` [rad]."""
    here, turn = _lanes_abreast(roads, position, heading)
    same = here[(np.abs(here) < ROAD) & (np.abs(turn) < np.pi / 4)]
    opposite = here[(np.abs(here) < ROAD) & (np.abs(turn) > 3 * np.pi / 4)]
    crossing = _crossing(roads, position, heading)
    junction = min(_to_junction(roads, position, heading) / JUNCTION, JUNCTIONS - 1)
    own = int((same > 1.75).sum())
    counts = [len(same), len(opposite), *crossing]
    return np.array([*np.minimum(counts, MOST_LANES), int(junction), min(own, MOST_LANES)], np.int64)


def retrieved(code: NDArray[np.integer], library: NDArray[np.integer], rng: np.random.Generator) -> int:
    """Which of the codes (C, 6) in the library is nearest, by weighted differences; a draw among equals.

    Raises UnusableInput for an empty library.
    """
    if len(library) == 0:
        raise UnusableInput("there is no map to retrieve: the library is empty")
    gap = (WEIGHTS * np.abs(library - code)).sum(axis=1)
    return int(rng.choice(np.flatnonzero(gap == gap.min())))


def library_codes(maps: Sequence[tuple[RoadMap, NDArray[np.floating], float]]) -> NDArray[np.int64]:
    """(C, 6) codes of maps with a target's position and heading each."""
    return np.stack([map_code(*each) for each in maps]) if maps else np.zeros((0, len(FIELDS)), np.int64)


def _lanes_abreast(
    roads: RoadMap, position: NDArray[np.floating], heading: float
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Offset to the left [m] and turn [rad] of every lane that passes the line across the target's heading."""
    offsets, turns = [], []
    for line in _seen(roads, roads.for_vehicles, position, heading):
        x = line[:, 0]
        for k in np.flatnonzero((x[:-1] <= 0) != (x[1:] <= 0)):
            share = -x[k] / (x[k + 1] - x[k])
            offsets.append(line[k, 1] + share * (line[k + 1, 1] - line[k, 1]))
            turns.append(line_heading(line)[k])
    return np.array(offsets), wrap_angle(np.array(turns))


def _crossing(roads: RoadMap, position: NDArray[np.floating], heading: float) -> tuple[int, int]:
    """How many lanes outside junctions run across the target's heading on its left and on its right."""
    sides = []
    for line in _seen(roads, roads.for_vehicles & ~roads.in_junction, position, heading):
        nearest = line[np.argmin(np.hypot(*line.T))]
        across = abs(np.sin(line_heading(line)[len(line) // 2])) > np.sin(np.pi / 4)
        if across and np.hypot(*nearest) < CROSSING and nearest[0] > -ROAD:
            sides.append(line[:, 1].mean() > 0)
    return sum(sides), len(sides) - sum(sides)


def _to_junction(roads: RoadMap, position: NDArray[np.floating], heading: float) -> float:
    """[m] to the nearest lane of a junction ahead; inf if there is none."""
    lines = _seen(roads, roads.in_junction & roads.for_vehicles, position, heading)
    points = np.concatenate([np.zeros((0, 2)), *lines])
    return float(np.hypot(*points[points[:, 0] > 0].T).min(initial=np.inf))


def _seen(
    roads: RoadMap, wanted: NDArray[np.bool_], position: NDArray[np.floating], heading: float
) -> list[NDArray[np.floating]]:
    """Centrelines (P, 2) [m] of the wanted lanes, a point every few metres, as the target sees them: x ahead, y left."""
    turn = np.array(-heading)
    lines = [roads.centreline[int(lane)].astype(np.float64) - position for lane in np.flatnonzero(wanted)]
    return [rotate(resample(line, STEP), turn) for line in lines]
