"""What tests of the checker and of drivers share: plain limits, an IDM, a road with an oncoming lane."""

import numpy as np

from drivegen.checker.limits import Limits
from drivegen.drivers import idm
from drivegen.roadmap import RoadMap
from tests.scenes import LANE_WIDTH, road_map

LIMITS = Limits(
    overlap=0.0,
    overlap_context=0.0,
    off_road=0.3,
    wrong_way=1.0,
    speed=40.0,
    over_limit=3.0,
    acceleration=4.0,
    braking=6.0,
    lateral_acceleration=4.0,
    velocity_error=1.0,
    curvature=0.2,
    side_slip=1.0,
    red_grace=0.5,
    stop_speed=2.0,
    yield_gap=0.5,
)

IDM = idm.Settings(
    desired_speed=13.9,
    headway=1.5,
    min_gap=2.0,
    acceleration=1.5,
    braking=2.0,
    emergency_braking=9.0,
    exponent=4.0,
    side_margin=0.0,
    look_ahead=0.0,
)


def two_way_road(length: float = 300.0) -> RoadMap:
    """Lane 0 along +x on y = 0, lane 1 back along -x on y = LANE_WIDTH."""
    xs = np.arange(0, length + 1, 10.0)
    there = np.stack([xs, np.zeros_like(xs)], axis=1)
    back = np.stack([xs[::-1], np.full_like(xs, LANE_WIDTH)], axis=1)
    return road_map([there, back])
