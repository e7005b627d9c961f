"""Lane surfaces from centrelines: boundaries, outlines and stop lines for a whole network at once."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Polylines, distinct

Points = NDArray[np.float64]

_SHARPEST = 0.25
"""Bound on 1 + cos of a bend, so that mitred corners reach out at most 2.8 half widths."""

_TESTED = (0.1, 0.5, 0.9)
"""Where along each segment of a boundary it is tested whether an outline holds it."""


def cleaned(line: Points, heading: float) -> Points:
    """The polyline without repeated points; one that is a single point becomes 5 cm along `heading`."""
    points: Points = distinct(line).astype(np.float64)
    if len(points) == 1:
        points = np.stack([points[0], points[0] + 0.05 * np.array([np.cos(heading), np.sin(heading)])])
    return points


def shifted(lines: Polylines, offset: Points) -> Polylines:
    """Every line i moved to its left by `offset[i]` [m], corners mitred."""
    points = lines.points.astype(np.float64)
    per_point = np.repeat(offset, np.diff(lines.start))
    ahead, behind = _normals(points, lines.start)
    both = ahead + behind
    scale = np.maximum(1.0 + (ahead * behind).sum(-1), _SHARPEST)
    moved = points + both * (per_point / scale)[:, None]
    return Polylines(moved.astype(np.float32), lines.start)


def _normals(points: Points, start: NDArray[np.int32]) -> tuple[Points, Points]:
    """Left unit normals (P, 2) of the segment after and before each point; at a line's ends both are the one there is."""
    step = np.diff(points, axis=0, append=points[-1:])
    length = np.maximum(np.hypot(step[:, 0], step[:, 1]), 1e-9)
    ahead = np.stack([-step[:, 1], step[:, 0]], axis=-1) / length[:, None]
    first, last = start[:-1], start[1:] - 1
    ahead[last] = ahead[last - 1]
    behind = np.roll(ahead, 1, axis=0)
    behind[first] = ahead[first]
    return ahead, behind


def outlines(left: Polylines, right: Polylines, keep: NDArray[np.bool_]) -> list[NDArray[np.float32]]:
    """Closed outlines of the lanes marked `keep` (L,)."""
    return [np.concatenate([right[i], left[i][::-1]]) for i in np.flatnonzero(keep).tolist()]


def covered(left: Points, right: Points, outline: Points) -> bool:
    """Whether a lane's surface lies within a closed outline (n, 2), judged between its ends, 5 % of its width left out."""
    sides = (left + 0.05 * (right - left), right + 0.05 * (left - right))
    points = np.concatenate([side[:-1] + share * np.diff(side, axis=0) for side in sides for share in _TESTED])
    x, y = points[:, :1], points[:, 1:]
    a, b = outline, np.roll(outline, -1, axis=0)
    rises = (a[:, 1] > y) != (b[:, 1] > y)  # edges that a ray to the right may cross
    at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
    return bool(((rises & (x < at)).sum(-1) % 2 == 1).all())


def crossing_corners(centre: Points, width: float) -> Points:
    """Corners (4, 2) of a pedestrian crossing that runs along `centre` (P, 2): one edge that way, then the other one back."""
    a, b = centre[0], centre[-1]
    along = (b - a) / max(float(np.hypot(*(b - a))), 1e-9)
    side = np.array([-along[1], along[0]]) * width / 2
    return np.stack([a + side, b + side, b - side, a - side])


def stop_lines(left: Polylines, right: Polylines, lanes: NDArray[np.int32]) -> NDArray[np.float32]:
    """Lines (S, 2, 2) across the far ends of `lanes` (S,), from right to left."""
    if not len(lanes):
        return np.zeros((0, 2, 2), np.float32)
    return np.stack([right.points[right.start[lanes + 1] - 1], left.points[left.start[lanes + 1] - 1]], axis=1)
