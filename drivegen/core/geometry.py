"""Plane geometry on arrays: angles, rigid frames, oriented boxes, polylines.

Metres and radians throughout; headings run counter-clockwise from +x, as in av2 and Waymax. All functions accept
any leading dimensions and keep the dtype of their input.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating]


def wrap_angle(angle: Floats) -> Floats:
    """The same angle in [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def unit(heading: Floats) -> Floats:
    """Unit vectors (..., 2) along `heading` (...)."""
    return np.stack([np.cos(heading), np.sin(heading)], axis=-1)


def rotate(points: Floats, angle: Floats) -> Floats:
    """Rotate `points` (..., 2) by `angle` (...), counter-clockwise about the origin."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = points[..., 0], points[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def to_vehicle_frame(points: Floats, position: Floats, heading: Floats) -> Floats:
    """World points (..., P, 2) as seen from poses `position` (..., 2), `heading` (...): x forward, y left."""
    return rotate(points - position[..., None, :], -heading[..., None])


def to_world_frame(points: Floats, position: Floats, heading: Floats) -> Floats:
    """The inverse of `to_vehicle_frame`."""
    return rotate(points, heading[..., None]) + position[..., None, :]


def box_corners(position: Floats, heading: Floats, length: Floats, width: Floats) -> Floats:
    """Corners (..., 4, 2) of oriented boxes, counter-clockwise from front left."""
    forward = unit(heading) * (length / 2)[..., None]
    left = np.stack([-np.sin(heading), np.cos(heading)], axis=-1) * (width / 2)[..., None]
    return np.stack(
        [position + forward + left, position - forward + left, position - forward - left, position + forward - left], axis=-2
    )


def boxes_overlap(
    position_a: Floats,
    heading_a: Floats,
    size_a: Floats,
    position_b: Floats,
    heading_b: Floats,
    size_b: Floats,
) -> NDArray[np.bool_]:
    """Whether oriented boxes a and b overlap (touching counts), by the separating axis theorem in closed form.

    Positions (..., 2), headings (...), sizes (..., 2) as length, width; leading dimensions broadcast. Two boxes are
    apart iff one of the four box axes separates them, and on an axis of a the half extent of b is
    `l_b |cos| + w_b |sin|` of the angle between them: no corners, no loops.
    """
    offset = position_b - position_a
    half_a, half_b = size_a / 2, size_b / 2
    cos = np.abs(np.cos(heading_b - heading_a))
    sin = np.abs(np.sin(heading_b - heading_a))

    def along(heading: Floats) -> tuple[Floats, Floats]:
        c, s = np.cos(heading), np.sin(heading)
        return np.abs(c * offset[..., 0] + s * offset[..., 1]), np.abs(c * offset[..., 1] - s * offset[..., 0])

    forward_a, left_a = along(heading_a)
    forward_b, left_b = along(heading_b)
    length_a, width_a, length_b, width_b = half_a[..., 0], half_a[..., 1], half_b[..., 0], half_b[..., 1]
    return (
        (forward_a <= length_a + length_b * cos + width_b * sin)
        & (left_a <= width_a + length_b * sin + width_b * cos)
        & (forward_b <= length_b + length_a * cos + width_a * sin)
        & (left_b <= width_b + length_a * sin + width_a * cos)
    )


def boxes_gap(
    position_a: Floats,
    heading_a: Floats,
    size_a: Floats,
    position_b: Floats,
    heading_b: Floats,
    size_b: Floats,
) -> Floats:
    """Distance (...) [m] between oriented boxes a and b, 0 where they overlap; arguments as in `boxes_overlap`.

    Two convex outlines that do not overlap are nearest at a corner of one of them.
    """
    corners_a = box_corners(position_a, heading_a, size_a[..., 0], size_a[..., 1])
    corners_b = box_corners(position_b, heading_b, size_b[..., 0], size_b[..., 1])
    corners_a, corners_b = np.broadcast_arrays(corners_a, corners_b)

    def outside(corners: Floats, position: Floats, heading: Floats, size: Floats) -> Floats:
        beyond = np.maximum(np.abs(to_vehicle_frame(corners, position, heading)) - size[..., None, :] / 2, 0)
        distance: Floats = np.hypot(beyond[..., 0], beyond[..., 1])
        return np.asarray(distance.min(axis=-1))

    gap = np.minimum(outside(corners_b, position_a, heading_a, size_a), outside(corners_a, position_b, heading_b, size_b))
    overlap = boxes_overlap(position_a, heading_a, size_a, position_b, heading_b, size_b)
    return np.where(overlap, np.zeros_like(gap), gap)


def arc_length(line: Floats) -> Floats:
    """Distance (P,) along the polyline (P, 2), 0 at its first point."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    return np.concatenate([np.zeros(1, line.dtype), np.cumsum(steps)]).astype(line.dtype)


def interpolate(line: Floats, distance: Floats) -> Floats:
    """Points (D, 2) at `distance` (D,) along the polyline (P, 2); clamped to its ends."""
    along = arc_length(line)
    return np.stack([np.interp(distance, along, line[:, 0]), np.interp(distance, along, line[:, 1])], axis=-1).astype(line.dtype)


def resample(line: Floats, spacing: float) -> Floats:
    """The polyline (P, 2) with points about `spacing` apart, both ends kept."""
    total = float(arc_length(line)[-1])
    count = max(2, int(np.ceil(total / spacing)) + 1)
    return interpolate(line, np.linspace(0.0, total, count))


REPEATED = 1e-3
"""A point that is no farther from the one before says nothing of where a line leads [m]."""


def distinct(line: Floats) -> Floats:
    """The polyline (P, 2) without repeated points; one point stays of a line that is a single place."""
    moves = np.hypot(*np.diff(line, axis=0).T) > REPEATED
    apart: Floats = line[np.concatenate([np.ones(min(1, len(line)), np.bool_), moves])]
    return apart


def line_heading(line: Floats) -> Floats:
    """Heading (P,) of the polyline (P, 2) at each point: that of the segment that follows it, the last repeated."""
    step = np.diff(line, axis=0)
    heading = np.arctan2(step[:, 1], step[:, 0])
    return np.concatenate([heading, heading[-1:]])


def project(line: Floats, point: Floats) -> tuple[float, float]:
    """Frenet coordinates of one `point` (2,) on the polyline (P, 2): distance along it, offset to the left of it."""
    start, step = line[:-1], np.diff(line, axis=0)
    squared = np.maximum((step**2).sum(-1), 1e-12)
    t = np.clip(((point - start) * step).sum(-1) / squared, 0.0, 1.0)
    gap = point - (start + t[:, None] * step)
    best = int(np.argmin((gap**2).sum(-1)))
    length = np.sqrt(squared[best])
    cross = step[best, 0] * gap[best, 1] - step[best, 1] * gap[best, 0]
    distance = float(np.hypot(*gap[best]))
    return float(arc_length(line)[best] + t[best] * length), float(np.copysign(distance, cross))


@dataclass(frozen=True)
class Polylines:
    """Many polylines in one array: line i is `points[start[i]:start[i + 1]]`.

    Attributes:
        points: (P, 2) float32 [m].
        start: (L + 1,) int32 row of each line's first point, and P at the end.
    """

    points: NDArray[np.float32]
    start: NDArray[np.int32]

    @classmethod
    def of(cls, lines: Sequence[Floats]) -> "Polylines":
        """Pack (P_i, 2) arrays."""
        start = np.cumsum([0, *(len(line) for line in lines)]).astype(np.int32)
        points = np.concatenate(lines) if lines else np.zeros((0, 2))
        return cls(points.astype(np.float32).reshape(-1, 2), start)

    def __len__(self) -> int:
        return len(self.start) - 1

    def __getitem__(self, i: int) -> NDArray[np.float32]:
        return self.points[self.start[i] : self.start[i + 1]]

    @property
    def whole(self) -> bool:
        """Whether the lines take up all points, one after the other."""
        first, last = self.start[[0, -1]] if len(self.start) else (-1, -1)
        return bool(first == 0 and last == len(self.points) and (np.diff(self.start) >= 0).all())

    def lines(self) -> list[NDArray[np.float32]]:
        """All lines as views (P_i, 2)."""
        return [self[i] for i in range(len(self))]

    def distinct(self) -> "Polylines":
        """The lines without repeated points; one point stays of a line that is a single place."""
        keep = np.hypot(*np.diff(self.points, axis=0, prepend=np.inf).T) > REPEATED
        keep[self.start[:-1][np.diff(self.start) > 0]] = True
        count = np.concatenate([np.zeros(1, np.int32), np.cumsum(keep, dtype=np.int32)])
        return Polylines(self.points[keep], count[self.start])

    def take(self, keep: NDArray[np.integer]) -> "Polylines":
        """The lines numbered `keep`, in that order."""
        return Polylines.of([self[int(i)] for i in keep])
