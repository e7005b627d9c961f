"""How far boxes are from the edge of the road, looked up in a raster of signed distances.

The raster is handed in (`roads.drivable.road_surface` makes one, of what is FARTHEST around the boxes at least). A place beyond
its border has the distance of the border's nearest cell: where a map is cut off lanes go on there, and so does what is no road.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.metrics.surroundings import Boxes

FARTHEST = 50.0
"""Boxes farther off the road than this [m] count as being so far off."""


@dataclass(frozen=True)
class RoadEdges:
    """Signed distances to the drivable area.

    Attributes:
        outside: (H, W) float32 [m], negative on the road. origin: (2,) float32 centre of the first cell [m].
        cell: edge of a cell [m].
        beyond_rim: which points (..., 2) lie where the map is cut off, so that nothing is known of them.
    """

    outside: NDArray[np.float32]
    origin: NDArray[np.float32]
    cell: float
    beyond_rim: Callable[[Floats], NDArray[np.bool_]]


def edge_distance(boxes: Boxes, vehicles: int, edges: RoadEdges) -> NDArray[np.float32]:
    """(K, N, T) signed distance of each vehicle's outermost corner to the road's edge [m], at most FARTHEST; off it above 0."""
    out = np.zeros((len(boxes.position), vehicles, boxes.valid.shape[2]), np.float32)
    road = (edges.outside, edges.origin, np.float32(1 / edges.cell))
    _outermost(boxes.position, boxes.cos, boxes.sin, boxes.valid, boxes.size, *road, out)
    return out


@njit(cache=True, error_model="numpy")
def _outermost(position, cos, sin, valid, size, outside, origin, per_metre, out):  # type: ignore[no-untyped-def]
    for k in range(out.shape[0]):
        for n in range(out.shape[1]):
            length, width = size[n, 0] / 2, size[n, 1] / 2
            for t in range(out.shape[2]):
                if not valid[k, n, t]:
                    continue
                farthest = np.float32(-np.inf)
                for along in (-length, length):
                    for across in (-width, width):
                        x = position[k, n, t, 0] + along * cos[k, n, t] - across * sin[k, n, t]
                        y = position[k, n, t, 1] + along * sin[k, n, t] + across * cos[k, n, t]
                        column, row = _cell(x, origin[0], per_metre), _cell(y, origin[1], per_metre)
                        farthest = max(farthest, _between(outside, column, row))
                out[k, n, t] = min(farthest, FARTHEST)


@njit(cache=True, inline="always")
def _cell(place, origin, per_metre):  # type: ignore[no-untyped-def]
    """In double precision, so that it hardly matters how much of a map was made a raster."""
    return (np.float64(place) - np.float64(origin)) * per_metre


@njit(cache=True, error_model="numpy")
def _between(field, x, y):  # type: ignore[no-untyped-def]
    """The field at column x, row y, between four cells; clamped to its border."""
    x = min(max(x, 0.0), field.shape[1] - 1.001)
    y = min(max(y, 0.0), field.shape[0] - 1.001)
    j, i = int(x), int(y)
    u, v = x - j, y - i
    upper = field[i, j] + u * (field[i, j + 1] - field[i, j])
    lower = field[i + 1, j] + u * (field[i + 1, j + 1] - field[i + 1, j])
    return upper + v * (lower - upper)
