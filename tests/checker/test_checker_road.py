import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.checker.road import LEAST, corner_outside
from drivegen.core.geometry import box_corners, rotate
from drivegen.roads.drivable import road_field
from tests.scenes import LANE_WIDTH, road_map


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
