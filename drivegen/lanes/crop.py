"""Cut a large map down to the surroundings of a scenario: a city network has thousands of lanes, a scenario needs some."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.errors import UnusableInput
from drivegen.geometry import Floats, Polylines
from drivegen.roadmap import NO_LANE, RoadMap


def crop(road_map: RoadMap, centre: Floats, radius: float) -> tuple[RoadMap, NDArray[np.int32]]:
    """Lanes, areas and crossings that come within `radius` [m] of `centre` (2,), whole, never clipped.

    Returns the map, cut links counted as dangling, and each old lane's new index (L,), NO_LANE where it was left out.
    Raises UnusableInput, reason `no-lanes`, where nothing is near.
    """
    keep = _near(road_map.centreline, centre, radius)
    if not keep.any():
        raise UnusableInput(f"the map has no lanes within {radius:g} m of the target", reason="no-lanes")
    index = np.where(keep, np.cumsum(keep) - 1, NO_LANE).astype(np.int32)
    areas = _near(road_map.drivable, centre, radius) | _boxed(road_map.drivable, centre)
    cropped = replace(
        road_map.take(keep),
        drivable=road_map.drivable.take(np.flatnonzero(areas)),
        crossings=road_map.crossings.take(np.flatnonzero(_near(road_map.crossings, centre, radius))),
    )
    return cropped, index


def _near(lines: Polylines, centre: Floats, radius: float) -> NDArray[np.bool_]:
    """(L,) whether any segment of each line comes within `radius`; all segments at once."""
    start, step = lines.points[:-1] - centre, np.diff(lines.points, axis=0)
    share = np.clip(-(start * step).sum(-1) / np.maximum((step**2).sum(-1), 1e-9), 0, 1)
    within = np.hypot(*(start + share[:, None] * step).T) <= radius
    within[lines.start[1:-1] - 1] = False  # from the last point of a line to the first of the next is no segment
    line = np.repeat(np.arange(len(lines)), np.diff(lines.start))[: len(within)]
    return np.bincount(line, within, len(lines)) > 0


def _boxed(outlines: Polylines, point: Floats) -> NDArray[np.bool_]:
    """(D,) whether each outline's bounding box holds the point: it may run far off all round."""
    return np.array([bool(((line.min(0) <= point) & (point <= line.max(0))).all()) for line in outlines.lines()], np.bool_)
