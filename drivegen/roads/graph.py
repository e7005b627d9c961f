"""The lane graph: one view of an Argoverse 2 or SUMO map on which routes, goals and traffic rules are computed.

Motor vehicles' lanes only (BIKE lanes keep their index, but nothing leads to them); bus lanes are among them, since logs show
vehicles there, and `barred` says who is not led onto them. Links in CSR form, centrelines with
no segment longer than `PIECE`, a grid for nearest-lane queries. Maps are often cropped: a lane without a predecessor
(successor) is also found up to `BEYOND` before its start (after its end), on its straight extension.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Polylines
from drivegen.core.roadmap import NO_LANE, LaneKind, RoadMap
from drivegen.core.scenario import VehicleKind
from drivegen.roads.grid import PIECE, LaneHits, SegmentGrid

BEYOND = 20.0
"""Length of the straight extensions at the ends of a cropped map [m]."""

WIDEST_HALF = 6.0
"""No half width is reported wider [m]: boundaries of odd lanes can be far away."""


@dataclass(frozen=True)
class Links:
    """Rows of variable length: row i is `lane[start[i]:start[i + 1]]`."""

    start: NDArray[np.int32]
    lane: NDArray[np.int32]

    def __getitem__(self, i: int) -> NDArray[np.int32]:
        return self.lane[self.start[i] : self.start[i + 1]]

    @classmethod
    def of(cls, pairs: NDArray[np.int32], lanes: int) -> "Links":
        """From rows (from, to), in any order, over `lanes` lanes."""
        order = np.lexsort((pairs[:, 1], pairs[:, 0]))
        start = np.searchsorted(pairs[order, 0], np.arange(lanes + 1)).astype(np.int32)
        return cls(start, np.ascontiguousarray(pairs[order, 1], np.int32))


@dataclass(frozen=True)
class LaneGraph:
    """L lanes of a map, indexed as in the map.

    Attributes:
        map: the map it was made of.
        usable: (L,) bool lanes for motor vehicles.
        length: (L,) float32 [m].
        heading: (L, 2) float32 [rad] at its start and end.
        successors, predecessors: Links between usable lanes.
        change: (L, 2) int32 usable lane to the left, right into which a lane change is legal, else NO_LANE.
        leaves_map: (L,) bool nothing follows, neither here nor by changing lanes: the map is cropped or ends.
        line: Polylines, the centrelines with every vertex kept and no segment longer than PIECE.
        along: (P,) float32 [m] arc length of each point of `line` within its lane.
        half_width: (P, 2) float32 [m] from each point of `line` to the left, right boundary.
        grid: SegmentGrid over the usable lanes and their straight extensions.
    """

    map: RoadMap
    usable: NDArray[np.bool_]
    length: NDArray[np.float32]
    heading: NDArray[np.float32]
    successors: Links
    predecessors: Links
    change: NDArray[np.int32]
    leaves_map: NDArray[np.bool_]
    line: Polylines
    along: NDArray[np.float32]
    half_width: NDArray[np.float32]
    grid: SegmentGrid

    @classmethod
    def of(cls, road_map: RoadMap) -> "LaneGraph":
        """Build the graph: a few milliseconds for an Argoverse 2 map, linear in the number of points."""
        count, usable = len(road_map), road_map.for_vehicles
        line, along, length = densified(road_map.centreline)
        links = road_map.links.reshape(-1, 2)
        links = links[usable[links].all(-1)]
        successors, predecessors = Links.of(links, count), Links.of(links[:, ::-1], count)
        change = lane_changes(road_map)
        ends = np.diff(successors.start) == 0
        half_width = np.stack(
            [_half_widths(line.points, line.start, side.points, side.start) for side in (road_map.left, road_map.right)], axis=-1
        )
        return cls(
            map=road_map,
            usable=usable,
            length=length,
            heading=_end_headings(line),
            successors=successors,
            predecessors=predecessors,
            change=change,
            leaves_map=leaves_map(ends, change) & usable,
            line=line,
            along=along,
            half_width=half_width,
            grid=_grid(line, along, usable, np.diff(predecessors.start) == 0, ends),
        )

    def __len__(self) -> int:
        return len(self.length)

    def barred(self, kind: int) -> NDArray[np.bool_]:
        """(L,) lanes onto which no way leads a vehicle of `kind` (VehicleKind) from other lanes: bus lanes, but for buses."""
        return np.equal(self.map.kind, LaneKind.BUS) & (kind != VehicleKind.BUS)

    def near(self, position: NDArray[np.floating], radius: float) -> LaneHits:
        """All usable lanes within `radius` [m] of `position` (2,), extensions included, nearest first."""
        return self.grid.near(position, radius)

    def nearest(
        self,
        positions: NDArray[np.floating],
        headings: NDArray[np.floating] | None = None,
        radius: float = 10.0,
        max_angle: float = np.pi,
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """The nearest lane of Q poses: lane (Q,), NO_LANE if none; and (Q, 4) s, d, lane heading, distance (inf if none).

        `positions` is (Q, 2), `headings` (Q,); only lanes that run within `max_angle` [rad] of the heading count.
        """
        if headings is None:
            headings = np.zeros(len(positions))
        return self.grid.nearest(positions, headings, radius, max_angle)

    def distance_to_lanes(self, points: NDArray[np.floating]) -> NDArray[np.float32]:
        """Distance (Q,) [m] of points (Q, 2) to the nearest centreline, inf where `nearest` finds none."""
        return self.nearest(points)[1][:, 3]


def densified(lines: Polylines) -> tuple[Polylines, NDArray[np.float32], NDArray[np.float32]]:
    """The lines with segments cut into equal parts no longer than PIECE; arc length per point; length per line."""
    points = lines.points.astype(np.float64)
    last = np.zeros(len(points), np.bool_)
    last[lines.start[1:] - 1] = True
    step = np.where(last[:, None], 0.0, np.diff(points, axis=0, append=points[-1:]))
    size = np.hypot(step[:, 0], step[:, 1])
    parts = np.maximum(np.ceil(size / PIECE), 1).astype(np.int64)
    owner = np.repeat(np.arange(len(points)), parts)
    first = np.cumsum(parts) - parts
    share = (np.arange(len(owner)) - first[owner]) / parts[owner]
    travelled = np.cumsum(size) - size
    travelled -= np.repeat(travelled[lines.start[:-1]], np.diff(lines.start))
    start = np.append(first, len(owner))[lines.start].astype(np.int32)
    dense = Polylines((points[owner] + share[:, None] * step[owner]).astype(np.float32), start)
    along = (travelled[owner] + share * size[owner]).astype(np.float32)
    return dense, along, along[dense.start[1:] - 1]


def _end_headings(line: Polylines) -> NDArray[np.float32]:
    """(L, 2) heading of each line's first and last segment."""
    first, last = line.start[:-1], line.start[1:] - 1
    step = np.stack([line.points[first + 1] - line.points[first], line.points[last] - line.points[last - 1]], axis=1)
    return np.arctan2(step[..., 1], step[..., 0])


def lane_changes(road_map: RoadMap) -> NDArray[np.int32]:
    """(L, 2) usable lane to the left, right of each usable one into which a lane change is legal, else NO_LANE."""
    neighbour, usable = road_map.neighbour, road_map.for_vehicles
    legal = road_map.may_change & (neighbour != NO_LANE) & usable[neighbour] & usable[:, None]
    return np.ascontiguousarray(np.where(legal, neighbour, NO_LANE), np.int32)


def leaves_map(ends: NDArray[np.bool_], change: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(L,) nothing follows, neither here nor on any lane that can be reached by changing lanes (a lane drop is no exit)."""
    leaves = ends.copy()
    for _ in range(8):  # across a road of up to nine lanes
        escapes = ((change != NO_LANE) & ~leaves[change]).any(-1)
        if not (leaves & escapes).any():
            break
        leaves &= ~escapes
    return leaves


def _grid(
    line: Polylines, along: NDArray[np.float32], usable: NDArray[np.bool_], starts: NDArray[np.bool_], ends: NDArray[np.bool_]
) -> SegmentGrid:
    """All pieces of usable lanes, and straight extensions before lanes that nothing leads to and after dead ends."""
    lane = np.repeat(np.arange(len(line), dtype=np.int32), np.diff(line.start))
    inside = usable[lane]
    inside[line.start[1:] - 1] = False
    first = np.flatnonzero(inside)
    pieces = [np.hstack([line.points[first], line.points[first + 1]])]
    lanes, distances = [lane[first]], [along[first]]
    offsets = np.arange(-BEYOND, 0.0, PIECE, dtype=np.float32)
    for at, onward, chosen, base in (
        (line.start[:-1], line.start[:-1] + 1, usable & starts, offsets),
        (line.start[1:] - 1, line.start[1:] - 2, usable & ends, offsets + BEYOND),
    ):
        which = np.flatnonzero(chosen).astype(np.int32)
        tip = line.points[at[which]]
        forward = (line.points[onward[which]] - tip) * np.sign(onward - at)[which, None]
        forward /= np.maximum(np.linalg.norm(forward, axis=-1, keepdims=True), 1e-6)
        a = tip[:, None] + base[:, None] * forward[:, None]
        b = a + PIECE * forward[:, None]
        pieces.append(np.concatenate([a, b], axis=-1).reshape(-1, 4))
        lanes.append(np.repeat(which, len(offsets)))
        distances.append((along[at[which]][:, None] + base).ravel())
    return SegmentGrid.of(np.concatenate(pieces), np.concatenate(lanes), np.concatenate(distances))


@njit(cache=True)
def _half_widths(points, start, side_points, side_start):  # type: ignore[no-untyped-def]
    """Distance (P,) from each centreline point to its own lane's boundary, at most WIDEST_HALF."""
    result = np.empty(len(points), np.float32)
    for i in range(len(start) - 1):
        for p in range(start[i], start[i + 1]):
            best = WIDEST_HALF
            for k in range(side_start[i], side_start[i + 1] - 1):
                ax, ay = side_points[k]
                ex, ey = side_points[k + 1, 0] - ax, side_points[k + 1, 1] - ay
                gx, gy = points[p, 0] - ax, points[p, 1] - ay
                share = min(max((gx * ex + gy * ey) / max(ex * ex + ey * ey, 1e-9), 0.0), 1.0)
                best = min(best, np.hypot(gx - share * ex, gy - share * ey))
            result[p] = best
    return result
