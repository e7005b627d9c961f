"""Plane geometry against slow but obvious ways to compute the same."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import (
    Polylines,
    arc_length,
    box_corners,
    boxes_overlap,
    interpolate,
    line_heading,
    project,
    resample,
    rotate,
    to_vehicle_frame,
    to_world_frame,
    wrap_angle,
)

coordinate = st.floats(-50, 50)
angle = st.floats(-10, 10)
extent = st.floats(0.5, 15)
quick = settings(max_examples=50, deadline=None)


def box(x, y, heading, length, width):
    return np.array([x, y]), np.array(heading), np.array([length, width])


def separation(one, other) -> float:
    """Widest gap between two convex outlines over all their edge normals; negative if they overlap, by how much."""
    corners = [box_corners(p, h, s[..., 0], s[..., 1]) for p, h, s in (one, other)]
    widest = -np.inf
    for outline in corners:
        for edge in np.roll(outline, -1, axis=0) - outline:
            axis = np.array([-edge[1], edge[0]]) / np.hypot(*edge)
            a, b = corners[0] @ axis, corners[1] @ axis
            widest = max(widest, a.min() - b.max(), b.min() - a.max())
    return float(widest)


@quick
@given(st.tuples(coordinate, coordinate, angle, extent, extent), st.tuples(coordinate, coordinate, angle, extent, extent))
def test_boxes_overlap_exactly_where_no_edge_separates_their_corners(one, other):
    a, b = box(*one), box(*other)
    gap = separation(a, b)
    if abs(gap) > 1e-6:
        assert bool(boxes_overlap(*a, *b)) == (gap < 0)


@quick
@given(st.tuples(coordinate, coordinate, angle, extent, extent), st.floats(0, 6.28), st.floats(0, 30))
def test_overlap_is_symmetric_and_does_not_depend_on_the_frame(one, direction, distance):
    a = box(*one)
    b = (a[0] + distance * np.array([np.cos(direction), np.sin(direction)]), a[1] + 0.7, a[2] * 0.5)
    if abs(separation(a, b)) < 1e-6:
        return
    first = bool(boxes_overlap(*a, *b))
    assert bool(boxes_overlap(*b, *a)) == first
    turned = [(rotate(p, np.array(1.3)), h + 1.3, s) for p, h, s in (a, b)]
    assert bool(boxes_overlap(*turned[0], *turned[1])) == first


def test_touching_boxes_count_as_overlapping():
    size = np.array([4.0, 2.0])
    assert boxes_overlap(np.zeros(2), np.array(0.0), size, np.array([4.0, 0.0]), np.array(0.0), size)
    assert not boxes_overlap(np.zeros(2), np.array(0.0), size, np.array([4.001, 0.0]), np.array(0.0), size)


def test_overlap_broadcasts_pairs_of_many_boxes():
    position = np.array([[0.0, 0.0], [3.0, 0.0], [30.0, 0.0]])
    heading, size = np.zeros(3), np.tile([4.0, 2.0], (3, 1))
    table = boxes_overlap(
        position[:, None], heading[:, None], size[:, None], position[None], heading[None], size[None]
    )  # fmt: skip
    assert table.tolist() == [[True, True, False], [True, True, False], [False, False, True]]


@quick
@given(st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=8), coordinate, coordinate, angle)
def test_frames_are_inverses_and_keep_distances(points, x, y, heading):
    points, position, heading = np.array(points), np.array([x, y]), np.array(heading)
    local = to_vehicle_frame(points, position, heading)
    np.testing.assert_allclose(to_world_frame(local, position, heading), points, atol=1e-9)
    np.testing.assert_allclose(np.hypot(*local.T), np.hypot(*(points - position).T), atol=1e-9)


def test_ahead_is_x_and_left_is_y_in_the_vehicle_frame():
    local = to_vehicle_frame(np.array([[10.0, 6.0], [9.0, 5.0]]), np.array([10.0, 5.0]), np.array(np.pi / 2))
    np.testing.assert_allclose(local, [[1, 0], [0, 1]], atol=1e-12)


@quick
@given(angle)
def test_wrapped_angles_point_the_same_way(value):
    wrapped = wrap_angle(np.array(value))
    assert -np.pi <= wrapped < np.pi
    np.testing.assert_allclose([np.cos(wrapped), np.sin(wrapped)], [np.cos(value), np.sin(value)], atol=1e-9)


steps = st.lists(st.tuples(st.floats(0.5, 10), st.floats(-5, 5)), min_size=1, max_size=8)


def line_of(moves) -> np.ndarray:
    return np.concatenate([np.zeros((1, 2)), np.cumsum(np.array(moves), axis=0)])


@quick
@given(steps, st.floats(0, 1))
def test_a_point_taken_from_a_line_projects_back_to_where_it_was(moves, share):
    line = line_of(moves)  # x always grows, so the line does not meet itself
    along = share * arc_length(line)[-1]
    point = interpolate(line, np.array([along]))[0]
    distance, offset = project(line, point)
    assert distance == pytest.approx(along, abs=1e-6)
    assert offset == pytest.approx(0, abs=1e-6)


@quick
@given(steps, st.floats(-60, 60), st.floats(-60, 60))
def test_projection_finds_the_nearest_point_of_the_line(moves, x, y):
    line, point = line_of(moves), np.array([x, y])
    distance, offset = project(line, point)
    dense = interpolate(line, np.linspace(0, arc_length(line)[-1], 2000))
    nearest = np.hypot(*(dense - point).T).min()
    assert abs(offset) <= nearest + 1e-9
    foot = interpolate(line, np.array([distance]))[0]
    assert np.hypot(*(foot - point)) == pytest.approx(abs(offset), abs=1e-6)


def test_left_of_the_line_is_positive():
    line = np.array([[0.0, 0.0], [10.0, 0.0]])
    assert project(line, np.array([4.0, 2.0])) == (4.0, 2.0)
    assert project(line, np.array([4.0, -2.0])) == (4.0, -2.0)


@quick
@given(steps, st.floats(0.2, 5))
def test_resampling_keeps_both_ends_and_the_spacing(moves, spacing):
    line = line_of(moves)
    points = resample(line, spacing)
    np.testing.assert_allclose(points[[0, -1]], line[[0, -1]], atol=1e-9)
    assert np.hypot(*np.diff(points, axis=0).T).max() <= spacing + 1e-9


def test_a_line_heads_along_its_segments_and_the_last_is_repeated():
    line = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose(line_heading(line), [0, np.pi / 2, np.pi / 2])


def test_packed_polylines_come_back_as_they_were_and_can_be_chosen():
    lines = [np.zeros((2, 2)), np.ones((3, 2)), np.full((4, 2), 2.0)]
    packed = Polylines.of(lines)
    assert len(packed) == 3
    for given_line, kept in zip(lines, packed.lines(), strict=True):
        np.testing.assert_array_equal(given_line, kept)
    np.testing.assert_array_equal(packed.take(np.array([2, 0])).start, [0, 4, 6])
    assert len(Polylines.of([])) == 0
