"""The static map M_s of a scenario: lanes with their links, drivable area, crossings, stop lines.

One type for Argoverse 2 and SUMO. A junction is not a thing of its own: as in Argoverse 2, the ways across it are
lanes (`in_junction`), in SUMO terms the internal lanes. What a driver must do before entering a lane is that lane's
`control`; a signalised lane is named by `Signals` in `signals.py`.
"""

from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import Floats, Polylines


class LaneKind(IntEnum):
    """Who may use a lane. Vehicles drive on VEHICLE and BUS lanes only; only buses are led onto BUS lanes."""

    VEHICLE = 0
    BUS = 1
    BIKE = 2


class LaneControl(IntEnum):
    """What holds before entering a lane; UNKNOWN where the source does not say (Argoverse 2 has no such layer)."""

    UNKNOWN = 0
    FREE = 1
    YIELD = 2
    STOP = 3
    SIGNAL = 4


NO_LANE = -1


def _no_pairs() -> NDArray[np.int32]:
    return np.zeros((0, 2), np.int32)


@dataclass(frozen=True)
class RoadMap:
    """Lanes as a struct of arrays, in a local frame.

    `local + origin` are the source's own coordinates (Argoverse 2 city frame, SUMO network frame); local ones are
    float32 and small, so nothing is lost far from a city's zero.

    Attributes:
        origin: (2,) float64 [m] position of the local frame in the source's frame (not rotated).
        lane_id: (L,) int64 the source's or our own number, unique.
        kind: (L,) uint8 LaneKind.
        centreline, left, right: Polylines of L lines each [m], all in driving direction.
        speed_limit: (L,) float32 [m/s], NaN where the source has none.
        in_junction: (L,) bool.
        control: (L,) uint8 LaneControl, what holds before entering.
        links: (E, 2) int32 rows (lane, its successor), sorted and unique; indices, not ids.
        neighbour: (L, 2) int32 lane beside to the left, right, else NO_LANE.
        same_direction: (L, 2) bool whether that neighbour runs the same way.
        may_change: (L, 2) bool whether a lane change to it is legal (same direction, markings allow it; never between lanes for
            bicycles and others). Who may be on a lane is said by `kind` alone.
        cut: (L, 2) bool whether lanes that lead to its start, on from its end, are missing here: the road goes on there, the
            map does not. Where neither a link nor a cut is, the network itself begins or ends.
        drivable: Polylines, closed outlines (first point not repeated); empty if unknown: the lanes' surfaces count.
        crossings: Polylines of four-cornered pedestrian crossings: one edge the way that people walk, then the other one back.
        stop_lines: (S, 2, 2) float32 [m] both ends.
        stop_lane: (S,) int32 the lane that is entered behind the stop line.
        dangling: number of links that named a lane the map does not hold (cropped maps: normal).
        yields_to: (Q, 2) int32 rows (lane that waits by a sign, lane that goes before it), sorted and unique; of ways across a
            junction, also where they never meet. Empty where the source does not say (SUMO alone does).
    """

    origin: NDArray[np.float64]
    lane_id: NDArray[np.int64]
    kind: NDArray[np.uint8]
    centreline: Polylines
    left: Polylines
    right: Polylines
    speed_limit: NDArray[np.float32]
    in_junction: NDArray[np.bool_]
    control: NDArray[np.uint8]
    links: NDArray[np.int32]
    neighbour: NDArray[np.int32]
    same_direction: NDArray[np.bool_]
    may_change: NDArray[np.bool_]
    cut: NDArray[np.bool_]
    drivable: Polylines
    crossings: Polylines
    stop_lines: NDArray[np.float32]
    stop_lane: NDArray[np.int32]
    dangling: int = 0
    yields_to: NDArray[np.int32] = field(default_factory=_no_pairs)

    def __len__(self) -> int:
        return len(self.lane_id)

    @property
    def for_vehicles(self) -> NDArray[np.bool_]:
        """(L,) lanes that motor vehicles use."""
        return np.not_equal(self.kind, LaneKind.BIKE)

    @property
    def is_cut_out(self) -> bool:
        """Whether roads go on beyond the map: nothing is known of what lies around it."""
        return bool(self.cut.any())

    def moved_to(self, origin: Floats) -> "RoadMap":
        """The same map in a local frame at `origin` (2,) [m, source frame]."""
        shift = (self.origin - np.asarray(origin, np.float64)).astype(np.float64)

        def move(lines: Polylines) -> Polylines:
            return Polylines((lines.points + shift).astype(np.float32), lines.start)

        return replace(
            self,
            origin=np.asarray(origin, np.float64),
            centreline=move(self.centreline),
            left=move(self.left),
            right=move(self.right),
            drivable=move(self.drivable),
            crossings=move(self.crossings),
            stop_lines=(self.stop_lines + shift).astype(np.float32),
        )

    def validate(self) -> None:
        """Raise UnusableInput unless shapes agree, indices are in range and every coordinate is finite."""
        count = len(self)
        if count == 0:
            raise UnusableInput("the map has no lanes", reason="no-lanes")
        per_lane = (self.kind, self.speed_limit, self.in_junction, self.control, self.neighbour, self.same_direction)
        lines = (self.centreline, self.left, self.right)
        if any(len(a) != count for a in (*per_lane, self.may_change, self.cut, *lines)):
            raise UnusableInput("the map's lane arrays differ in length", reason="bad-map")
        ids, times = np.unique(self.lane_id, return_counts=True)
        if len(ids) != count:
            raise UnusableInput(f"the map has two lanes of the id {ids[times > 1][0]}", reason="bad-map")
        short = np.min([np.diff(line.start) for line in lines], axis=0) < 2
        if short.any():
            lane = self.lane_id[short][0]
            raise UnusableInput(f"lane {lane} of the map has a line of fewer than two different points", reason="bad-map")
        if not all(line.whole for line in (*lines, self.drivable, self.crossings)):
            raise UnusableInput("the map has a line that does not hold its points", reason="bad-map")
        if any((np.diff(outline.start) == 0).any() for outline in (self.drivable, self.crossings)):
            raise UnusableInput("the drivable area or a crossing of the map has an outline without points", reason="bad-map")
        odd = (
            (self.kind > max(LaneKind)) | (self.control > max(LaneControl)) | (self.speed_limit < 0) | np.isinf(self.speed_limit)
        )
        if odd.any():
            lane = self.lane_id[odd][0]
            raise UnusableInput(f"lane {lane} of the map has a kind, a control or a speed limit that is none", reason="bad-map")
        points = (line.points for line in (*lines, self.drivable, self.crossings))
        numbers: tuple[NDArray[np.floating], ...] = (self.origin, self.stop_lines, *points)
        if not all(np.isfinite(array).all() for array in numbers):
            raise UnusableInput("the map has coordinates that are not numbers", reason="bad-map")
        self._expect_links(count)

    def _expect_links(self, count: int) -> None:
        for indices, low in ((self.links, 0), (self.neighbour, NO_LANE), (self.stop_lane, 0), (self.yields_to, 0)):
            if indices.size and (indices.min() < low or indices.max() >= count):
                raise UnusableInput("the map links to a lane that it does not hold", reason="bad-map")


def open_ends(links: NDArray[np.integer], lanes: int) -> NDArray[np.bool_]:
    """(L, 2) whether no link (E, 2) leads to the start, on from the end, of each of `lanes` lanes."""
    linked = np.zeros((lanes, 2), np.bool_)
    linked[links[:, 1], 0] = linked[links[:, 0], 1] = True
    return ~linked
