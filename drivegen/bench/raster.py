"""The 256 x 256 raster around a vehicle that image networks take in."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.core.geometry import rotate
from drivegen.roads.raster import CHANNELS, RasterMap, raster

EXTENT = 100.0
SCENES = 2


def rows() -> Iterator[Row]:
    """Half a millisecond is wanted; the reference only turns the lines into the vehicle's frame, one by one."""
    prepared = RasterMap.of(_scene.road_map())
    vehicles = [_scene.scene(number).vehicles for number in range(SCENES)]
    poses = [pose for v in vehicles for pose in zip(v.position, v.heading, strict=True)]
    lines = [*_scene.road_map().left.lines(), *_scene.road_map().right.lines(), *_scene.road_map().centreline.lines()]

    def draw() -> None:
        for position, heading in poses:
            raster(prepared, position, float(heading), EXTENT, CHANNELS)

    def turn() -> None:
        for position, heading in poses:
            _one_by_one(lines, position, heading)

    value = best_cpu_seconds(draw) / len(poses) * 1e3
    reference = best_cpu_seconds(turn) / len(poses) * 1e3
    yield Row("raster 256 x 256", value, "ms", 0.5, True, reference, "turning the lines one by one, undrawn")


def _one_by_one(lines: list[NDArray[np.float32]], position: NDArray[np.float32], heading: NDArray[np.float32]) -> None:
    for line in lines:
        np.rint(rotate(line - position, -heading) * 256 / EXTENT).astype(np.int32)
