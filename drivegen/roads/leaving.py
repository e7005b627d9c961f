"""Leaving the map: a vehicle whose front crosses an end of the road network is gone, as in a log of a simulator.

An exit is the end of a vehicle lane that no lane follows, neither ahead nor beside it, and that is not cut: the network itself
ends there. Ends that are cut are no exits: the road goes on, so the vehicle does, too, though the map does not say where.
This is the one rule for all motion, whoever made it.
"""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import bounds
from drivegen.core.roadmap import RoadMap, open_ends
from drivegen.core.scenario import Trajectories
from drivegen.roads.graph import lane_changes, leaves_map

BESIDE = 2.0
"""An exit reaches this far beyond its lane's boundaries [m]: who leaves between two lanes leaves."""

STAYS = -1
"""The step at which somebody leaves who does not."""


@dataclass(frozen=True)
class Exits:
    """The G exits of a map.

    Attributes:
        point: (G, 2) float32 [m] end of the lane's middle. forward: (G, 2) float32 unit vector of the way out.
        reach: (G,) float32 [m] to either side of the point.
        lane: (G,) int32 the lane that ends.
    """

    point: NDArray[np.float32]
    forward: NDArray[np.float32]
    reach: NDArray[np.float32]
    lane: NDArray[np.int32]

    @classmethod
    def of(cls, road_map: RoadMap) -> "Exits":
        """Those of a map; none where every end is cut."""
        lane = np.flatnonzero(_exits(road_map)).astype(np.int32)
        last = road_map.centreline.start[lane + 1] - 1
        point = road_map.centreline.points[last]
        step = point - road_map.centreline.points[last - 1]
        sides = [side.points[side.start[lane + 1] - 1] - point for side in (road_map.left, road_map.right)]
        half = np.max([np.hypot(*side.T) for side in sides], axis=0) if len(lane) else np.zeros(0)
        forward = step / np.maximum(np.hypot(*step.T), 1e-6)[:, None]
        return cls(point, forward.astype(np.float32), (half + BESIDE).astype(np.float32), lane)

    def __len__(self) -> int:
        return len(self.lane)

    def crossings(self, motion: Trajectories, length: NDArray[np.floating]) -> NDArray[np.int16]:
        """(...) first step of motion (..., T) at which the front of a vehicle of `length` (...) [m] is out; STAYS if never.

        It was behind the exit at its last valid step before. Of a box that stands across the exit from the beginning the
        middle counts.
        """
        shape = motion.valid.shape[:-1]
        if not len(self) or not motion.valid.size:
            return np.full(shape, STAYS, np.int16)
        flat = motion.position.reshape(-1, motion.steps, 2), motion.heading.reshape(-1, motion.steps)
        valid = motion.valid.reshape(-1, motion.steps)
        half = np.ascontiguousarray(np.broadcast_to(length, shape).reshape(-1) / 2, np.float32)
        return np.asarray(_crossings(*flat, valid, half, self.point, self.forward, self.reach)).reshape(shape)

    def leave(self, motion: Trajectories, length: NDArray[np.floating]) -> Trajectories:
        """The motion (..., T), not valid from where a vehicle of `length` (...) [m] leaves; see `left_from`."""
        return left_from(motion, self.crossings(motion, length))


def left_from(motion: Trajectories, step: NDArray[np.integer]) -> Trajectories:
    """The motion (..., T), not valid from `step` (...) on, STAYS for none; the last pose is repeated there."""
    if (step < 0).all():
        return motion
    gone = (step >= 0)[..., None] & (np.arange(motion.steps) >= step[..., None])
    return replace(motion.standing_after_end(motion.valid & ~gone), valid=motion.valid & ~gone)


def _exits(road_map: RoadMap) -> NDArray[np.bool_]:
    """(L,) lanes at whose end the network ends."""
    usable = road_map.for_vehicles
    links = road_map.links.reshape(-1, 2)
    ends = open_ends(links[usable[links].all(-1)], len(road_map))[:, 1]
    return leaves_map(ends, lane_changes(road_map)) & usable & ~road_map.cut[:, 1]


@njit(cache=True)
def _crossings(position, heading, valid, half, point, forward, reach):  # type: ignore[no-untyped-def]
    first = np.full(len(valid), STAYS, np.int16)
    boxes = bounds(position, valid)
    for b in range(len(valid)):
        for g in range(len(point)):
            near = reach[g] + half[b]
            if point[g, 0] < boxes[b, 0] - near or point[g, 0] > boxes[b, 2] + near:
                continue
            if point[g, 1] < boxes[b, 1] - near or point[g, 1] > boxes[b, 3] + near:
                continue
            for lead in (half[b], np.float32(0.0)):
                step = _crossing(position[b], heading[b], valid[b], lead, point[g], forward[g], reach[g])
                if step >= 0 and (first[b] < 0 or step < first[b]):
                    first[b] = step
    return first


@njit(cache=True)
def _crossing(position, heading, valid, lead, point, forward, reach):  # type: ignore[no-untyped-def]
    """First step at which the point `lead` [m] ahead of the middle has crossed one exit; STAYS if never."""
    before, beside = np.float32(np.inf), np.float32(0.0)  # along and left of the way out, at the last valid step
    for t in range(len(valid)):
        if not valid[t]:
            continue
        x = position[t, 0] + lead * np.cos(heading[t]) - point[0]
        y = position[t, 1] + lead * np.sin(heading[t]) - point[1]
        along, left = x * forward[0] + y * forward[1], y * forward[0] - x * forward[1]
        if before < 0 <= along:
            across = beside + (left - beside) * before / (before - along)
            if abs(across) <= reach:
                return t
        before, beside = along, left
    return STAYS
