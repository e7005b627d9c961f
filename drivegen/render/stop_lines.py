"""Which stop lines of a road map a picture shows, and what holds at each.

A road map has a stop line wherever some way out of a lane has to yield, to stop or to heed a signal, so a main road has one
where only who turns left has to yield. Whoever sees a line across a lane takes it for all that drive on there.
"""

import numpy as np

from drivegen.core.geometry import Floats, wrap_angle
from drivegen.core.roadmap import LaneControl, RoadMap

STRAIGHT_ON = np.pi / 4
"""Whoever turns by less [rad] across a junction drives straight on."""


def shown_stop_lines(road_map: RoadMap) -> list[tuple[Floats, LaneControl]]:
    """Both ends (2, 2) [m] of each line with what holds for who drives straight on, or, where nobody can, for everybody.

    Lines at which that is FREE are left out, as are those inside junctions, where nothing is painted on the road.
    """
    inside = set(road_map.links[road_map.in_junction[road_map.links[:, 0]], 1].tolist())
    entered: dict[bytes, list[int]] = {}
    for ends, way in zip(road_map.stop_lines, road_map.stop_lane.tolist(), strict=True):
        if way not in inside:
            entered.setdefault(ends.tobytes(), []).append(way)
    lines = [(np.frombuffer(key, np.float32).reshape(2, 2), ways) for key, ways in entered.items()]
    found = [(ends, _holds(road_map, ends, ways)) for ends, ways in lines]
    return [(ends, control) for ends, control in found if control != LaneControl.FREE]


def _holds(road_map: RoadMap, ends: Floats, entered: list[int]) -> LaneControl:
    """What holds at a line before the ways `entered`; the lane that ends there may have others out of it."""
    before = road_map.links[np.isin(road_map.links[:, 1], entered), 0]
    if not len(before):  # cut off at the edge of the map
        return LaneControl(max(road_map.control[entered]))
    last = np.stack([road_map.centreline[int(lane)][-1] for lane in before])
    lane = int(before[np.argmin(np.hypot(*(last - ends.mean(0)).T))])
    ways = road_map.links[road_map.links[:, 0] == lane, 1]
    start = _heading(road_map.centreline[lane][-2:])
    turns = [abs(wrap_angle(_exit_heading(road_map, int(way)) - start)) for way in ways]
    straightest = int(np.argmin(turns))
    if turns[straightest] < STRAIGHT_ON:
        return LaneControl(road_map.control[ways[straightest]])
    return LaneControl(road_map.control[ways].min())


def _exit_heading(road_map: RoadMap, way: int) -> Floats:
    """Heading [rad] with which `way` leaves the junction; it may go on in another one behind a place to wait in."""
    for _ in range(len(road_map)):
        onward = road_map.links[road_map.links[:, 0] == way, 1]
        if not road_map.in_junction[way] or not len(onward):
            break
        way = int(onward[0])
    line = road_map.centreline[way]
    return _heading(line[-2:] if road_map.in_junction[way] else line[:2])


def _heading(ends: Floats) -> Floats:
    along = ends[1] - ends[0]
    heading: Floats = np.arctan2(along[1], along[0])
    return heading
