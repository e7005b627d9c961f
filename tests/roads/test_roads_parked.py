"""Who is parked: beside all lanes and standing, either alone is not enough."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.roads.graph import LaneGraph
from drivegen.roads.parked import parked
from tests import scenes

ROADS = scenes.straight_road(400, 1)


@pytest.mark.parametrize(
    ("aside", "speed", "expected"),
    [(0.0, 0.0, False), (1.9, 0.0, False), (-2.1, 0.0, True), (2.1, 0.4, True), (2.1, 0.6, False), (60.0, 0.0, True)],
)
def test_who_stands_beside_all_lanes_is_parked(aside: float, speed: float, expected: bool) -> None:
    vehicles = scenes.scenario(ROADS, scenes.drive(scenes.joined(ROADS, 0), 100, 0.0, 101)[None]).vehicles
    moved = replace(vehicles, position=vehicles.position + np.array([0, aside], np.float32), speed=np.array([speed], np.float32))
    assert parked(LaneGraph.of(ROADS), moved).tolist() == [expected]


def test_whichever_way_the_lane_leads_who_stands_on_it_is_not_parked() -> None:
    vehicles = scenes.scenario(ROADS, scenes.drive(scenes.joined(ROADS, 0), 100, 0.0, 101)[None]).vehicles
    for turned in (np.pi / 2, np.pi):
        assert not parked(LaneGraph.of(ROADS), replace(vehicles, heading=vehicles.heading + np.float32(turned))).any()
