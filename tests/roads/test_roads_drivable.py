import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import Polylines, rotate
from drivegen.roads.drivable import CELL, EVERY_DIRECTION, FAR, LIMIT_UNIT, MARGIN, road_field, road_surface, sectors
from tests.scenes import LANE_WIDTH, LIMIT, crossing, road_map, straight_road


def at(field, raster, x, y):
    return raster[round((y - field.origin[1]) / CELL), round((x - field.origin[0]) / CELL)]


@settings(max_examples=20, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-40, 40), st.floats(-40, 40))
def test_distance_to_the_edge_of_a_road_is_right_within_cells_for_any_direction(angle, x, y):
    line = rotate(np.stack([np.linspace(-60, 60, 13), np.zeros(13)], axis=1), np.float64(angle)) + np.array([x, y])
    field = road_field(road_map([line]))
    across = np.array([-5.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 5.0])
    points = rotate(np.stack([np.zeros(9), across], axis=1), np.float64(angle)) + np.array([x, y])
    assert field.distance_outside(points) == pytest.approx(np.abs(across) - LANE_WIDTH / 2, abs=CELL * 2**0.5)


def test_a_road_goes_on_where_the_map_is_cut_but_not_beside_it():
    field = road_field(straight_road(100, 1))
    assert field.distance_outside(np.array([[104.0, 0.0]]))[0] < 0
    assert field.distance_outside(np.array([[104.0, 6.0]]))[0] > 3
    assert field.distance_outside(np.array([[500.0, 6.0]]))[0] == -np.inf
    assert field.beyond_rim(np.array([[104.0, 0.0], [500.0, 6.0]])).all()
    assert not field.beyond_rim(np.array([[97.0, 0.0], [104.0, 6.0]])).any()


def test_where_the_network_ends_so_does_the_road():
    field = road_field(straight_road(100, 1, whole=True))
    assert field.distance_outside(np.array([[98.0, 0.0]]))[0] < 0
    assert field.distance_outside(np.array([[104.0, 0.0]]))[0] == pytest.approx(4.0, abs=0.65)
    assert field.distance_outside(np.array([[500.0, 6.0]]))[0] == FAR
    assert not field.beyond_rim(np.array([[98.0, 0.0], [104.0, 0.0], [500.0, 6.0]])).any()


def test_without_a_drivable_area_the_lanes_are_the_road():
    roads = straight_road()
    assert len(roads.drivable) == 1
    bare = road_field(road_map(roads.centreline.lines()))
    whole = road_field(roads)
    assert bare.distance_outside(np.array([[50.0, 0.0]]))[0] < 0
    assert bare.distance_outside(np.array([[50.0, 7.0]]))[0] == pytest.approx(
        whole.distance_outside(np.array([[50.0, 7.0]]))[0], abs=0.3
    )


def test_a_hole_between_two_overlapping_outlines_is_no_hole():
    square = np.array([[0, 0], [40, 0], [40, 40], [0, 40]], np.float64)
    roads = road_map([[[0, -20], [40, -20]]], drivable=[square, square])
    assert road_field(roads).distance_outside(np.array([[20.0, 20.0]]))[0] < -10


def test_cells_know_the_directions_and_limits_of_their_lanes():
    field = road_field(crossing())
    east, west = at(field, field.directions, -50, -1.75), at(field, field.directions, -50, 1.75)
    assert east & (1 << int(sectors(np.array(0.01)))) or east & (1 << int(sectors(np.array(-0.01))))
    assert west & (1 << int(sectors(np.array(np.pi - 0.01)))) or west & (1 << int(sectors(np.array(np.pi + 0.01))))
    assert not east & west
    assert at(field, field.directions, 0, 1.75) == EVERY_DIRECTION
    assert at(field, field.directions, -50, 30) == 0
    assert at(field, field.limit, -50, -1.75) * LIMIT_UNIT == pytest.approx(LIMIT, abs=LIMIT_UNIT)
    assert at(field, field.limit, -50, 30) == 0


@given(st.floats(-20, 20))
def test_a_direction_has_the_same_sector_after_a_whole_turn(angle):
    assert 0 <= sectors(np.array(angle)) < 16
    inside = (np.floor(angle * 16 / (2 * np.pi)) + 0.5) * 2 * np.pi / 16
    assert sectors(np.array(inside)) == sectors(np.array(inside + 2 * np.pi))


def test_a_map_without_lanes_for_vehicles_is_an_empty_road():
    roads = straight_road()
    bikes = road_map([roads.centreline[0]], drivable=[])
    bikes.kind[:] = 2
    field = road_field(bikes)
    assert (field.outside > 0).all()
    assert not field.directions.any()
    assert isinstance(bikes.drivable, Polylines)


@settings(max_examples=30, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-400, 400), st.floats(-60, 60), st.floats(-60, 60), st.floats(30, 200))
@example(-2.2638254728883025, -36.8, 0.4, -4.0, 60.0)
@example(0.3, 100.0, 10.0, 5.0, 1500.0)
def test_a_surface_made_around_points_is_the_same_there_as_that_of_the_whole_map(angle, away, x, y, half):
    line = rotate(np.stack([np.linspace(-half, half, 13), np.zeros(13)], axis=1), np.float64(angle)) + np.array([away, -away])
    whole = road_map([line])  # cut at both ends, where strips of 50 m go on
    beside = rotate(
        np.stack(np.meshgrid(np.linspace(-6, 6, 9), np.linspace(-3, 3, 9)), axis=-1).reshape(-1, 2), np.float64(angle)
    )
    points = np.concatenate([beside + end for end in (line[0], line[-1], line[6])] + [[[away + x, y - away]]]).astype(np.float32)
    surface, field = road_surface(whole, points), road_field(whole)
    near = np.abs(field.distance_outside(points)) < MARGIN
    assert np.array_equal(surface.distance_outside(points)[near], field.distance_outside(points)[near])
    assert (np.abs(surface.distance_outside(points))[~near] >= MARGIN).all()
    assert np.array_equal(surface.beyond_rim(points), field.beyond_rim(points))
