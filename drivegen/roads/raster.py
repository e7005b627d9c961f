"""The map around a vehicle as pixels, for networks: 256 x 256, vehicle in the middle, heading up (paper, Implement Details).

The paper says no more than "256x256 vehicle-centric rasterized map"; which channels and how many metres it shows is up to
the caller. Lines are drawn with OpenCV in fixed point, one call per channel: a fraction of a millisecond per raster.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, Polylines
from drivegen.core.roadmap import RoadMap
from drivegen.roads.graph import densified

CHANNELS = ("surface", "boundaries", "centrelines")
"""surface: lanes of motor vehicles, filled. boundaries: their edges. centrelines: thin, in driving direction brighter."""

PIXELS = 256

_SHIFT = 3  # fractional bits of pixel coordinates
_LEVELS = (110, 255)  # grey of a centreline's first and second half: shows which way it runs

cv2.setNumThreads(1)


@dataclass(frozen=True)
class RasterMap:
    """A map made ready to be drawn many times.

    Attributes:
        points: (P, 2) float32 [m] of all lines: left edge and reversed right edge of every lane, then the centrelines.
        start: (3 L + 1,) first row of each line: 2 L edges (left, right, left, ...), L centrelines.
        middle, radius: (L, 2), (L,) a circle around each lane [m].
    """

    points: NDArray[np.float32]
    start: NDArray[np.int32]
    middle: NDArray[np.float32]
    radius: NDArray[np.float32]

    @classmethod
    def of(cls, road_map: RoadMap) -> "RasterMap":
        """Lanes of motor vehicles only."""
        lanes = np.flatnonzero(road_map.for_vehicles)
        edges = [line for i in lanes for line in (road_map.left[int(i)], road_map.right[int(i)][::-1])]
        centres = [road_map.centreline[int(i)] for i in lanes]
        packed, _, _ = densified(Polylines.of([*edges, *centres]))  # pixels far beyond the image are moved to its surroundings
        rings = [np.concatenate([edges[2 * k], edges[2 * k + 1], centres[k]]) for k in range(len(lanes))]
        low, high = (np.array([f(ring, axis=0) for ring in rings]).reshape(-1, 2) for f in (np.min, np.max))
        return cls(packed.points, packed.start, (low + high) / 2, np.hypot(*(high - low).T) / 2)


def raster(prepared: RasterMap, position: Floats, heading: float, extent: float, channels: Sequence[str]) -> NDArray[np.uint8]:
    """(C, 256, 256) uint8 of the square of `extent` [m] about the pose: `channels` of CHANNELS, each 0..255.

    Row 0 is ahead of the vehicle, column 0 on its left; position (2,) [m], heading [rad].
    """
    reach = extent / np.sqrt(2)
    near = np.flatnonzero(np.hypot(*(prepared.middle - position).T) < prepared.radius + reach)
    pixels = _to_pixels(prepared.points, position, heading, extent)
    first = prepared.start.tolist()
    image = np.zeros((len(channels), PIXELS, PIXELS), np.uint8)
    for layer, channel in zip(image, channels, strict=True):
        if channel == "surface":
            for k in near:  # one by one: in one call overlapping lanes would cancel out
                cv2.fillPoly(layer, [pixels[first[2 * k] : first[2 * k + 2]]], 255, shift=_SHIFT)
        elif channel == "boundaries":
            edges = [pixels[first[i] : first[i + 1]] for k in near for i in (2 * k, 2 * k + 1)]
            cv2.polylines(layer, edges, False, 255, shift=_SHIFT)
        elif channel == "centrelines":
            centres = 2 * len(prepared.radius) + near
            _draw_centrelines(layer, [pixels[first[i] : first[i + 1]] for i in centres])
        else:
            raise ValueError(f"no raster channel {channel!r}: choose of {CHANNELS}")
    return image


def _to_pixels(points: NDArray[np.float32], position: Floats, heading: float, extent: float) -> NDArray[np.int32]:
    """Fixed-point pixel coordinates (P, 2), column then row, of all points by one matrix."""
    scale = PIXELS / extent
    cos, sin = scale * np.cos(heading), scale * np.sin(heading)
    # Ahead (cos, sin) is up, that is -row; left (-sin, cos) is -column.
    turn = np.array([[sin, -cos], [-cos, -sin]], np.float32)
    pixels = (points - np.asarray(position, np.float32)) @ turn + PIXELS / 2 - 0.5
    return np.asarray(np.rint(np.clip(pixels, -2000, 2000) * (1 << _SHIFT)), np.int32)


def _draw_centrelines(layer: NDArray[np.uint8], lines: list[NDArray[np.int32]]) -> None:
    halves = [len(line) // 2 for line in lines]
    cv2.polylines(layer, [line[: h + 1] for line, h in zip(lines, halves, strict=True)], False, _LEVELS[0], shift=_SHIFT)
    cv2.polylines(layer, [line[h:] for line, h in zip(lines, halves, strict=True)], False, _LEVELS[1], shift=_SHIFT)
