"""What several tests share: plain limits, an IDM, a road with an oncoming lane, how far off the road what was made is."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import Actors, Scenario
from drivegen.drivers import idm
from drivegen.metrics.road_edge import RoadEdges, edge_distance
from drivegen.metrics.surroundings import Boxes
from drivegen.roads.drivable import CELL, road_field
from drivegen.sumo.network import Network
from tests.scenes import LANE_WIDTH, road_map

LIMITS = Limits(
    overlap=0.0,
    overlap_context=0.0,
    off_road=0.3,
    wrong_way=1.0,
    oncoming_lanes=0.5,
    speed=40.0,
    over_limit=3.0,
    acceleration=4.0,
    braking=6.0,
    lateral_acceleration=4.0,
    velocity_error=1.0,
    jump=0.5,
    velocity_step=1.0,
    curvature=0.2,
    side_slip=1.0,
    spin=1.0,
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
    heeds_rules=False,
    gives_way=True,
    accepted_gap=4.0,
)


def two_way_road(length: float = 300.0) -> RoadMap:
    """Lane 0 along +x on y = 0, lane 1 back along -x on y = LANE_WIDTH."""
    xs = np.arange(0, length + 1, 10.0)
    there = np.stack([xs, np.zeros_like(xs)], axis=1)
    back = np.stack([xs[::-1], np.full_like(xs, LANE_WIDTH)], axis=1)
    return road_map([there, back])


def off_the_road(scenario: Scenario, network: Network) -> NDArray[np.float32]:
    """(N, T) [m] how far the outermost corner of each vehicle's box is off the road of the whole network, 0 where it is gone."""
    field = road_field(network.map)
    assert scenario.log is not None
    shift = (scenario.map.origin - network.map.origin).astype(np.float32)
    motion = replace(scenario.log, position=scenario.log.position + shift)[np.newaxis]
    boxes = Boxes.of(motion, scenario.vehicles.size, Actors.none(scenario.steps))
    edges = RoadEdges(field.outside, field.origin, CELL, field.beyond_rim)
    return np.maximum(np.where(motion.valid, edge_distance(boxes, len(scenario.vehicles), edges), 0), 0)[0]


FARTHEST_OFF = 1.0
"""No step of a vehicle that is made lies farther off the road than this [m]."""
