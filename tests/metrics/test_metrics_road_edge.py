"""Distance to the road's edge: by hand on a raster of known distances."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.scenario import Actors, Trajectories
from drivegen.metrics.road_edge import FARTHEST, RoadEdges, edge_distance
from drivegen.metrics.surroundings import Boxes
from drivegen.roads.drivable import CELL, covered, road_field, road_surface
from tests.scenes import LANE_WIDTH, crossing, straight_road

SIZE = np.float32([[4.0, 2.0]])


def at(points, headings, valid=None) -> Boxes:
    position = np.float32(points)[None, None]
    heading = np.float32(headings)[None, None]
    known = np.ones(heading.shape[1:], np.bool_) if valid is None else np.array([valid])
    motion = Trajectories(position, heading, np.zeros_like(position), known[None])
    return Boxes.of(motion, SIZE, Actors.none(heading.shape[-1]))


def half_plane() -> RoadEdges:
    """The road is x < 5; cells of half a metre around the origin."""
    columns = np.arange(-20, 20.5, 0.5, dtype=np.float32)
    return RoadEdges(
        np.tile(columns - 5, (len(columns), 1)), np.float32([-20, -20]), 0.5, lambda points: np.zeros(points.shape[:-1], np.bool_)
    )


def test_the_outermost_corner_counts():
    found = edge_distance(at([(0, 0), (0, 0), (4.3, 2.2)], [0, np.pi / 2, np.pi / 4]), 1, half_plane())
    corner = 4.3 + (2.0 + 1.0) / np.sqrt(2)
    np.testing.assert_allclose(found[0, 0], [-3.0, -4.0, corner - 5], atol=1e-5)


def test_beyond_the_raster_its_border_holds_and_unknown_steps_are_zero():
    found = edge_distance(at([(100, 0), (-100, 90), (0, 0)], [0, 0, 0], [True, True, False]), 1, half_plane())
    np.testing.assert_allclose(found[0, 0], [15.0, -25.0, 0.0], atol=0.01)


@pytest.mark.parametrize("offset", [0.0, 0.4, 1.0, 2.5])
def test_on_a_drawn_road_it_is_right_to_a_fraction_of_a_cell(offset):
    field = road_field(straight_road(100.0, 1))
    edges = RoadEdges(field.outside, field.origin, CELL, field.beyond_rim)
    found = edge_distance(at([(50, offset)], [0]), 1, edges)[0, 0, 0]
    assert found == pytest.approx(offset + 1.0 - LANE_WIDTH / 2, abs=0.7 * CELL)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.floats(-300, 400), st.floats(-300, 300)), min_size=1, max_size=6), st.floats(-3, 3))
def test_a_raster_around_the_boxes_says_of_them_what_that_of_the_whole_map_says(points, heading):
    roads = crossing()
    boxes = at(points, [heading] * len(points))
    part, whole = road_surface(roads, covered(np.float32(points), SIZE), FARTHEST), road_surface(roads)
    near, far = (edge_distance(boxes, 1, RoadEdges(one.outside, one.origin, CELL, one.beyond_rim)) for one in (part, whole))
    assert np.array_equal(near, far)
    assert near.max() <= FARTHEST
