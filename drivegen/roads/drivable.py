"""The road as rasters that rules are looked up in: distance to the drivable area, lane directions, speed limits.

A look-up costs nanoseconds whatever the map's size, and the rasters are made once per map in a few milliseconds.
Where a map is cut nobody knows how the road goes on, so lanes are continued straight by `BEYOND` at cut ends, and around a map
that is a cut-out everything outside the raster counts as road without rules: beyond its rim nothing is claimed. Where the
network itself ends, so does the road.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Polylines, unit
from drivegen.core.roadmap import RoadMap, open_ends

CELL = 0.5
"""Edge of a cell [m]; distances are unbiased, off by 0.13 m (one sigma) where interpolated, by a diagonal at most by cell."""

MARGIN = 10.0
"""Width of the border around the map that still belongs to the raster [m]."""

BEYOND = 50.0
"""Length by which lanes are continued at cut ends [m]."""

PIECE = 4.0
"""Length of the pieces into which lanes are cut, one direction each [m]: longer edges are drawn differently where cut off."""

_MOST_PIECES = 10_000
"""Of a line, however long a file says it is."""

SECTORS = 16
"""Number of directions told apart; bit i of a cell stands for headings from i to i + 1 sixteenths of a turn."""

EVERY_DIRECTION = np.uint16(0xFFFF)
FAR = 100.0
"""Distance to a road that is not there [m]."""

LIMIT_UNIT = 0.5
"""Speed limits are stored in steps of half a metre per second, rounded up; 0 is unknown."""

_SUBPIXEL = 4
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)


@dataclass(frozen=True)
class RoadSurface:
    """Where road is; cell (row, column) has its centre at `origin + CELL * (column, row)`.

    Attributes:
        origin: (2,) float32 [m] centre of the first cell in the map's frame.
        outside: (H, W) float32 [m] signed distance to the drivable area, negative inside.
        rim: (H, W) bool cells that are road only because a lane is cut before them.
        around: signed distance [m] of everything outside the raster: -inf around a cut-out, FAR around a whole network.
    """

    origin: NDArray[np.float32]
    outside: NDArray[np.float32]
    rim: NDArray[np.bool_]
    around: float

    def distance_outside(self, points: NDArray[np.floating]) -> NDArray[np.float32]:
        """Signed distance (...) [m] of points (..., 2) to the drivable area, of their cell; `around` beyond the raster."""
        row, column, inside = self._cells(points)
        return np.where(inside, self.outside[row, column], np.float32(self.around))

    def beyond_rim(self, points: NDArray[np.floating]) -> NDArray[np.bool_]:
        """(...) whether points (..., 2) lie where the map is cut off: what is there nobody knows."""
        row, column, inside = self._cells(points)
        return np.where(inside, self.rim[row, column], self.around < 0)

    def _cells(self, points: NDArray[np.floating]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
        """Row and column (...) of the cells of points (..., 2), 0 where they are not inside (...) the raster."""
        cell = np.rint((points.astype(np.float64) - self.origin) / CELL).astype(np.int64)  # a tie is one in every window
        inside = (cell >= 0).all(axis=-1) & (cell[..., 1] < self.outside.shape[0]) & (cell[..., 0] < self.outside.shape[1])
        return np.where(inside, cell[..., 1], 0), np.where(inside, cell[..., 0], 0), inside


@dataclass(frozen=True)
class RoadField(RoadSurface):
    """Where road is, which way it leads and how fast one may drive.

    Attributes:
        directions: (H, W) uint16 bit mask of the headings of the lanes that cover the cell; all bits inside junctions,
            0 where no lane is.
        limit: (H, W) uint8 highest speed limit of these lanes in LIMIT_UNIT, 0 where unknown.
    """

    directions: NDArray[np.uint16]
    limit: NDArray[np.uint8]


@dataclass(frozen=True)
class _Quads:
    corner: NDArray[np.float32]  # (Q, 4, 2)
    heading: NDArray[np.float32]  # (Q,)
    lane: NDArray[np.int32]  # (Q,)


@dataclass(frozen=True)
class _Frame:
    """Which part of the plane is painted: its first cell's centre [m] and (rows, columns)."""

    low: NDArray[np.float64]
    shape: tuple[int, int]

    @classmethod
    def of(cls, map_: RoadMap, quads: _Quads, about: NDArray[np.floating] | None, margin: float) -> "_Frame":
        """Of the whole map, or of what of it is within `margin` [m] of the points (P, 2)."""
        points = np.concatenate([quads.corner.reshape(-1, 2), map_.drivable.points, map_.centreline.points])
        low, high = np.floor(points.min(0) - MARGIN), points.max(0) + MARGIN
        if about is not None:
            least, most = np.clip([about.min(0), about.max(0)], low, high)  # beyond the frame its border is asked
            low, high = np.maximum(np.floor(least - margin), low), np.minimum(most + margin, high)
        width, height = (np.ceil((high - low) / CELL).astype(int) + 1).tolist()
        return cls(low.astype(np.float64), (height, width))

    def pixels(self, outline: NDArray[np.floating]) -> NDArray[np.int32]:
        """Points (..., 2) [m] as OpenCV's whole numbers, with _SUBPIXEL bits behind the point."""
        pixels: NDArray[np.int32] = np.rint((outline - self.low) * (2**_SUBPIXEL / CELL)).astype(np.int32)
        return pixels


def road_field(map_: RoadMap, about: NDArray[np.floating] | None = None) -> RoadField:
    """The rasters of `map_`. The drivable area is that of the map joined with its vehicle lanes, or the lanes alone.

    With points `about` (P, 2) [m] they are made only around these, which takes a fraction of the time. What they say of these
    points is then the same, distances up to MARGIN; nobody may ask for other points.
    """
    quads = _lane_pieces(map_)
    frame = _Frame.of(map_, quads, about, MARGIN)
    surface = _surface(map_, quads, frame)
    pieces = frame.pixels(quads.corner)
    near = _touching(pieces, frame.shape)
    pieces, lane = pieces[near], quads.lane[near]
    return RoadField(
        surface.origin, surface.outside, surface.rim, surface.around,
        _directions(map_, quads.heading[near], lane, pieces, frame.shape), _limits(map_, lane, pieces, frame.shape),
    )  # fmt: skip


def road_surface(map_: RoadMap, about: NDArray[np.floating] | None = None, margin: float = MARGIN) -> RoadSurface:
    """As `road_field`, without directions and limits; distances of the points `about` are the same up to `margin` [m]."""
    quads = _lane_pieces(map_)
    return _surface(map_, quads, _Frame.of(map_, quads, about, margin))


def _surface(map_: RoadMap, quads: _Quads, frame: _Frame) -> RoadSurface:
    road = np.zeros(frame.shape, np.uint8)
    for outline in map_.drivable.lines():
        cv2.fillPoly(road, [frame.pixels(_cut(outline))], 1, shift=_SUBPIXEL)
    _paint(road, frame.pixels(quads.corner))
    mapped = road.copy()
    _paint(road, frame.pixels(_continuations(map_, quads)))
    around = float(-np.inf) if map_.is_cut_out else FAR
    return RoadSurface(frame.low.astype(np.float32), _signed_distance(road), road > mapped, around)


def covered(places: NDArray[np.floating], size: NDArray[np.floating]) -> NDArray[np.float64] | None:
    """Two corners (2, 2) [m] of what boxes of `size` (N, 2 or 3) [m] cover, any of them at any of the places (P, 2) [m].

    Places that are not finite count for nothing; None where no other is.
    """
    there = places[np.isfinite(places).all(axis=-1)].astype(np.float64)
    reach = float(np.hypot(*size[:, :2].T).max(initial=0.0)) / 2
    return np.stack([there.min(0) - reach, there.max(0) + reach]) if len(there) else None


def sectors(heading: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Number of the direction sector of each heading [rad], of any shape."""
    number: NDArray[np.uint8] = np.floor(heading * (SECTORS / (2 * np.pi))).astype(np.int64).astype(np.uint8) % SECTORS
    return number


def _fill(plane: NDArray[np.uint8], pieces: NDArray[np.int32], values: NDArray[np.integer]) -> None:
    for piece, value in zip(pieces, values.tolist(), strict=True):
        cv2.fillConvexPoly(plane, piece, value, shift=_SUBPIXEL)


def _touching(pieces: NDArray[np.int32], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """(Q,) which of the pieces (Q, 4, 2) touch a plane of `shape`."""
    size = np.array(shape[::-1]) << _SUBPIXEL
    return np.asarray((pieces.max(axis=1) >= -1).all(axis=-1) & (pieces.min(axis=1) <= size).all(axis=-1))


def _paint(road: NDArray[np.uint8], pieces: NDArray[np.int32]) -> None:
    """Mark the pieces (Q, 4, 2) as road."""
    near = _touching(pieces, road.shape)
    _fill(road, pieces[near], np.ones(near.sum(), np.int64))


def _signed_distance(road: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Negative inside: the distance to the road's outermost cells, which outlines run through, so it is 0 on them."""
    if not road.any():
        return np.full(road.shape, FAR, np.float32)
    edge = road - cv2.erode(road, _CROSS, borderType=cv2.BORDER_CONSTANT, borderValue=1)
    signed: NDArray[np.float32] = cv2.distanceTransform(1 - edge, cv2.DIST_L2, 5)
    signed *= np.float32(CELL)
    return np.negative(signed, out=signed, where=road.view(np.bool_))


def _directions(
    map_: RoadMap, heading: NDArray[np.float32], lane: NDArray[np.int32], pieces: NDArray[np.int32], shape: tuple[int, int]
) -> NDArray[np.uint16]:
    sector = sectors(heading).astype(np.int64)
    sector[map_.in_junction[lane]] = SECTORS
    low, high, plane = (np.zeros(shape, np.uint8) for _ in range(3))  # of the mask, byte by byte: OpenCV joins bytes fastest
    for i in np.unique(sector).tolist():
        chosen = pieces[sector == i]
        plane[:] = 0
        _fill(plane, chosen, np.full(len(chosen), 255 if i == SECTORS else 1 << i % 8))
        for half in (low, high) if i == SECTORS else (low,) if i < 8 else (high,):
            cv2.bitwise_or(half, plane, dst=half)
    return low | np.left_shift(high, 8, dtype=np.uint16)


def _limits(map_: RoadMap, lane: NDArray[np.int32], pieces: NDArray[np.int32], shape: tuple[int, int]) -> NDArray[np.uint8]:
    limit = map_.speed_limit[lane]
    code = np.ceil(np.clip(np.nan_to_num(limit) / LIMIT_UNIT, 0, 255)).astype(np.int64)
    rising = np.argsort(code, kind="stable")  # the highest limit is painted last
    plane = np.zeros(shape, np.uint8)
    _fill(plane, pieces[rising], code[rising])
    return plane


def _lane_pieces(map_: RoadMap) -> _Quads:
    """The surfaces of vehicle lanes, cut into pieces of about PIECE metres."""
    lanes = np.flatnonzero(map_.for_vehicles)
    length = _lengths(map_.centreline)[lanes]
    count = np.clip(np.ceil(length / PIECE), 1, _MOST_PIECES).astype(np.int64)
    lane = np.repeat(lanes, count)
    index = np.arange(len(lane)) - np.repeat(np.cumsum(count) - count, count)
    begin, end = index / np.repeat(count, count), (index + 1) / np.repeat(count, count)
    corner = np.stack(
        [_at(map_.left, lane, begin), _at(map_.left, lane, end), _at(map_.right, lane, end), _at(map_.right, lane, begin)], axis=1
    )
    step = _at(map_.centreline, lane, end) - _at(map_.centreline, lane, begin)
    return _Quads(corner.astype(np.float32), np.arctan2(step[:, 1], step[:, 0]).astype(np.float32), lane.astype(np.int32))


def _continuations(map_: RoadMap, quads: _Quads) -> NDArray[np.float32]:
    """Pieces (S, 4, 2) of the strips by which vehicle lanes go on at ends where they are cut and nothing follows."""
    lanes, first = np.unique(quads.lane, return_index=True)
    last = np.append(first[1:], len(quads.lane)) - 1
    cut = (map_.cut & open_ends(map_.links, len(map_)))[lanes]
    strips = []
    begin = np.arange(0.0, BEYOND, PIECE, dtype=np.float32)[:, None, None]
    end = np.minimum(begin + PIECE, np.float32(BEYOND))
    for rows, (left, right), way in ((first[cut[:, 0]], (0, 3), -1), (last[cut[:, 1]], (1, 2), 1)):
        ahead = unit(quads.heading[rows]).astype(np.float32) * np.float32(way)
        a, b = quads.corner[rows, left], quads.corner[rows, right]
        pieces = np.stack([a + begin * ahead, a + end * ahead, b + end * ahead, b + begin * ahead], axis=2)
        strips.append(pieces.reshape(-1, 4, 2))
    return np.concatenate(strips)


@njit(cache=True)
def _cut(outline):  # type: ignore[no-untyped-def]
    """The closed outline (P, 2) with a point at least every PIECE metres."""
    corners = len(outline)
    x, y = outline[:, 0].astype(np.float64), outline[:, 1].astype(np.float64)
    parts = np.empty(corners, np.int64)
    for i in range(corners):
        j = (i + 1) % corners
        parts[i] = min(max(np.ceil(np.hypot(x[j] - x[i], y[j] - y[i]) / PIECE), 1), _MOST_PIECES)
    points, count = np.empty((parts.sum(), 2)), 0
    for i in range(corners):
        j = (i + 1) % corners
        for k in range(parts[i]):
            points[count, 0], points[count, 1] = x[i] + (x[j] - x[i]) / parts[i] * k, y[i] + (y[j] - y[i]) / parts[i] * k
            count += 1
    return points


def _lengths(lines: Polylines) -> NDArray[np.float64]:
    along = _global_arc(lines)
    return np.asarray(along[lines.start[1:] - 1] - along[lines.start[:-1]])


def _global_arc(lines: Polylines) -> NDArray[np.float64]:
    """Arc length over all lines one after the other, one metre between them, so that one `interp` serves all."""
    step = np.hypot(*np.diff(lines.points.astype(np.float64), axis=0).T)
    step[lines.start[1:-1] - 1] = 1.0
    return np.concatenate([np.zeros(1), np.cumsum(step)])


def _at(lines: Polylines, line: NDArray[np.integer], fraction: NDArray[np.floating]) -> NDArray[np.float64]:
    """Points (Q, 2) at `fraction` (Q,) of the length of lines number `line` (Q,)."""
    along = _global_arc(lines)
    begin, end = along[lines.start[:-1]][line], along[lines.start[1:] - 1][line]
    places = begin + fraction * (end - begin)
    return np.stack([np.interp(places, along, lines.points[:, axis]) for axis in (0, 1)], axis=-1)
