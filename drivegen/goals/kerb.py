"""Where a vehicle may pull over: at the right edge of its lane, as soon as it can stop gently, if nothing drives to its right."""

from drivegen.core.roadmap import NO_LANE, RoadMap
from drivegen.roads.line import SPACING, Route

GENTLE = 2.0
"""Braking of who pulls over [m/s2]."""

NEAREST = 8.0
"""Nobody gets to the kerb in fewer metres."""

FASTEST = 17.0
"""Nobody parks on a road with a higher limit [m/s], nor comes to it faster."""

CLEAR = 0.3
"""Between the vehicle's side and the edge of the lane [m]."""


def kerb_place(route: Route, road_map: RoadMap, speed: float, width: float, seconds: float) -> tuple[float, float] | None:
    """s and d [m] of the place for a vehicle of `width` [m] with `speed` [m/s]; None where it can't or may not park.

    Traffic keeps to the right; on the left-hand side of the world this is the lane's inner edge and of little use.
    """
    s = max(speed**2 / (2 * GENTLE), NEAREST)
    at = int(s / SPACING)
    if speed > FASTEST or speed / GENTLE > seconds or at >= len(route.lane) or s > route.exit_s:
        return None
    lane = int(route.lane[at])
    beside, limit = int(road_map.neighbour[lane, 1]), float(route.speed_limit[at])
    if road_map.in_junction[lane] or limit > FASTEST or (beside != NO_LANE and road_map.same_direction[lane, 1]):
        return None
    room = float(route.half_width_right[at]) - width / 2 - CLEAR
    return (s, -room) if room > 0 else None
