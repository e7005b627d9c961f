"""Distance between oriented boxes, against points on their outlines."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import box_corners, boxes_gap, boxes_overlap, interpolate


def outline(position, heading, size):
    """Points every few centimetres along the box's sides."""
    corners = box_corners(position, np.float64(heading), size[0], size[1])
    return interpolate(np.concatenate([corners, corners[:1]]), np.arange(0, 2 * size.sum(), 0.02))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_the_gap_is_the_smallest_distance_between_the_outlines_and_nothing_where_boxes_overlap(seed):
    random = np.random.default_rng(seed)
    a, b = ((random.uniform(-6, 6, 2), random.uniform(-4, 4), random.uniform(1, 6, 2)) for _ in range(2))
    gap = float(boxes_gap(*map(np.asarray, (*a, *b))))
    if boxes_overlap(*map(np.asarray, (*a, *b))):
        assert gap == 0
    else:
        apart = np.hypot(*np.moveaxis(outline(*a)[:, None] - outline(*b)[None], -1, 0)).min()
        np.testing.assert_allclose(gap, apart, atol=0.02)


def test_leading_dimensions_broadcast():
    size = np.array([4.0, 2.0])
    gap = boxes_gap(np.zeros((1, 5, 2)), np.zeros((1, 5)), size, np.full((3, 5, 2), (10, 0)), np.zeros((3, 5)), size)
    assert gap.shape == (3, 5)
    np.testing.assert_allclose(gap, 6.0)
