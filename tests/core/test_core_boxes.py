import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.boxes import bounds, depth, separation
from drivegen.core.geometry import box_corners, boxes_gap, boxes_overlap, to_vehicle_frame

metres = st.floats(-8, 8)
angles = st.floats(-7, 7)
sides = st.floats(0.3, 12)


def overlaps_by_points(dx, dy, heading_a, size_a, heading_b, size_b, grid=60):
    """Brute force: does any point of a dense grid over one box lie in the other?"""
    boxes = ((np.zeros(2), heading_a, size_a), (np.array([dx, dy]), heading_b, size_b))
    for own, other in (boxes, boxes[::-1]):
        corners = box_corners(own[0], np.float64(own[1]), np.float64(own[2][0]), np.float64(own[2][1]))
        u, v = np.meshgrid(np.linspace(0, 1, grid), np.linspace(0, 1, grid))
        points = corners[0] + u.reshape(-1, 1) * (corners[1] - corners[0]) + v.reshape(-1, 1) * (corners[3] - corners[0])
        seen = np.abs(to_vehicle_frame(points, other[0], np.float64(other[1])))
        if (seen <= np.array(other[2]) / 2).all(axis=-1).any():
            return True
    return False


@settings(max_examples=50, deadline=None)
@given(metres, metres, angles, sides, sides, angles, sides, sides)
def test_depth_agrees_with_arrays_and_with_brute_force(dx, dy, heading_a, la, wa, heading_b, lb, wb):
    deep = depth(dx, dy, heading_a, la, wa, heading_b, lb, wb)
    if abs(deep) > 1e-9:
        zero, size_a, size_b = np.zeros(2), np.array([la, wa]), np.array([lb, wb])
        assert bool(boxes_overlap(zero, np.float64(heading_a), size_a, np.array([dx, dy]), np.float64(heading_b), size_b)) == (
            deep > 0
        )
    coarsest = max(la, wa, lb, wb) / 59
    if abs(deep) > 2 * coarsest:
        assert overlaps_by_points(dx, dy, heading_a, (la, wa), heading_b, (lb, wb)) == (deep > 0)


@settings(max_examples=50, deadline=None)
@given(metres, metres, angles, sides, sides, angles, sides, sides)
def test_depth_is_symmetric(dx, dy, heading_a, la, wa, heading_b, lb, wb):
    there = depth(dx, dy, heading_a, la, wa, heading_b, lb, wb)
    back = depth(-dx, -dy, heading_b, lb, wb, heading_a, la, wa)
    assert abs(there - back) < 1e-9


def test_depth_is_how_far_boxes_must_move_apart():
    assert np.isclose(depth(4.0, 0.5, 0.0, 4.6, 1.9, 0.0, 4.6, 1.9), 0.6)
    assert np.isclose(depth(5.0, 0.0, 0.0, 4.6, 1.9, 0.0, 4.6, 1.9), -0.4)


def test_bounds_take_valid_steps_only():
    position = np.array([[[0, 0], [5, -2], [99, 99]]], np.float32)
    valid = np.array([[True, True, False]])
    assert bounds(position, valid).tolist() == [[0, -2, 5, 0]]
    assert bounds(position, ~valid & False)[0, 0] == np.inf


@settings(max_examples=50, deadline=None)
@given(metres, metres, angles, sides, sides, angles, sides, sides)
def test_separation_is_the_gap_where_apart_and_the_depth_where_not(dx, dy, heading_a, la, wa, heading_b, lb, wb):
    turns = (np.cos(heading_a), np.sin(heading_a), la, wa, np.cos(heading_b), np.sin(heading_b), lb, wb)
    found = separation(dx, dy, *turns)
    box_b = (np.array([dx, dy]), np.float64(heading_b), np.array([lb, wb]))
    gap = float(boxes_gap(np.zeros(2), np.float64(heading_a), np.array([la, wa]), *box_b))
    wanted = gap if gap > 0 else -depth(dx, dy, heading_a, la, wa, heading_b, lb, wb)
    np.testing.assert_allclose(found, wanted, atol=1e-6)
    np.testing.assert_allclose(separation(-dx, -dy, *turns[4:], *turns[:4]), found, atol=1e-6)
