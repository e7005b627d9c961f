from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.checker.limits import RULES
from drivegen.checker.road import LEAST, NOTICED, corner_outside
from drivegen.checker.scene import SceneChecker
from drivegen.core.geometry import box_corners, rotate
from drivegen.core.scenario import Trajectories
from drivegen.roads.drivable import road_field
from tests.checking import LIMITS
from tests.scenes import LANE_WIDTH, drive, road_map, scenario, stack, straight_road


@settings(max_examples=30, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1), st.floats(-4, 4))
def test_the_outermost_corner_is_found_within_a_cell(road, heading, aside):
    """A box turned by `heading` on a straight road that runs in direction `road`, `aside` from its middle."""
    line = rotate(np.stack([np.linspace(-60, 60, 13), np.zeros(13)], axis=1), np.float64(road))
    field = road_field(road_map([line]))
    x, y = rotate(np.array([3.0, aside]), np.float64(road))
    found = corner_outside(
        field.outside,
        LEAST,
        field.origin,
        np.float32(x),
        np.float32(y),
        *np.float32([np.cos(heading), np.sin(heading)]),
        np.float32(4.6),
        np.float32(1.9),
    )
    corners = rotate(box_corners(np.array([x, y]), np.float64(heading), np.float64(4.6), np.float64(1.9)), np.float64(-road))
    truth = np.abs(corners[:, 1]).max() - LANE_WIDTH / 2
    if abs(truth) < 3:
        assert found == pytest.approx(truth, abs=0.5)


def test_who_stands_off_the_road_is_off_it_after_a_gap_in_its_track():
    x, y = np.full(101, 100.0), np.where(np.arange(101) < 4, 0.0, -8.0)
    still = np.zeros(101, np.float32)
    motion = Trajectories(np.stack([x, y], -1).astype(np.float32), still, np.zeros((101, 2), np.float32), np.ones(101, np.bool_))
    worst = []
    for gap in (0, 2):
        seen = stack([motion])
        seen.valid[0, 6 : 6 + gap] = False
        judged = SceneChecker(scenario(straight_road(whole=True), seen), LIMITS).severities(seen[np.newaxis])
        worst.append(float(judged.worst[0, 0, RULES.index("off_road")]))
    assert worst[0] > 5
    assert worst[1] == worst[0]


@pytest.mark.parametrize(("acceleration", "legal"), [(0.0, False), (-0.3, False), (-0.8, True)])
def test_who_starts_too_fast_has_to_slow_down(acceleration: float, legal: bool):
    road = straight_road(600)
    log = stack([drive(road.centreline[0].astype(np.float64), 20, 20.0, 101, acceleration)])
    judged = SceneChecker(scenario(road, log), LIMITS).severities(log[np.newaxis])
    assert (judged.violation[0, 0] == 0) is np.bool_(legal)
    assert legal or judged.first[0, 0, RULES.index("over_limit")] >= NOTICED


def test_who_comes_too_fast_to_where_limits_begin_did_not_start_so():
    xs = np.arange(0.0, 601.0, 10.0)
    line = np.stack([xs, 0 * xs], axis=1)
    road = road_map([line[:31], line[30:]], links=[(0, 1)])
    road = replace(road, speed_limit=np.array([np.nan, 13.9], np.float32))
    log = stack([drive(line, 290, 20.0, 101)])
    judged = SceneChecker(scenario(road, log), LIMITS).severities(log[np.newaxis])
    assert judged.first[0, 0, RULES.index("over_limit")] in (4, 6)
