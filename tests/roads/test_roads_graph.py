"""The lane graph against brute force and against what the hand-made maps are known to hold."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import project
from drivegen.core.roadmap import NO_LANE, LaneKind
from drivegen.roads.graph import BEYOND, LaneGraph
from drivegen.roads.grid import MOST_HITS, SegmentGrid
from tests import scenes

CROSSING = scenes.crossing()
GRAPH = LaneGraph.of(CROSSING)


def test_links_run_both_ways():
    for a, b in CROSSING.links.tolist():
        assert b in GRAPH.successors[a]
        assert a in GRAPH.predecessors[b]
    assert GRAPH.successors.lane.size == len(CROSSING.links) == GRAPH.predecessors.lane.size


def test_centrelines_keep_length_and_vertices_and_have_no_long_segment():
    for i in range(len(CROSSING)):
        step = np.hypot(*np.diff(GRAPH.line[i], axis=0).T)
        assert step.max() <= 4.001
        assert np.isclose(step.sum(), GRAPH.length[i], rtol=1e-4)
        for vertex in CROSSING.centreline[i]:
            assert np.hypot(*(GRAPH.line[i] - vertex).T).min() < 1e-4


def test_half_widths_are_half_the_lanes_width():
    assert np.allclose(LaneGraph.of(scenes.straight_road()).half_width, scenes.LANE_WIDTH / 2, atol=1e-3)


@settings(max_examples=50, deadline=None)
@given(x=st.floats(-95, 95), y=st.floats(-95, 95), radius=st.floats(0.5, 20))
def test_near_finds_what_a_search_over_all_lanes_finds(x, y, radius):
    point = np.array([x, y])
    hits = GRAPH.near(point, radius)
    inside = (hits.s >= 0) & (hits.s <= GRAPH.length[hits.lane])
    found = dict(zip(hits.lane[inside].tolist(), hits.distance[inside].tolist(), strict=True))
    for lane in range(len(CROSSING)):
        s, d = project(CROSSING.centreline[lane].astype(np.float64), point)
        if abs(d) < radius - 1e-2 and 0 < s < GRAPH.length[lane]:
            assert np.isclose(found[lane], abs(d), atol=1e-2)
    assert (np.diff(hits.distance) >= 0).all()


@pytest.mark.parametrize("seed", range(5))
def test_of_more_lanes_than_a_query_reports_the_nearest_are_kept(seed):
    away = np.random.default_rng(seed).uniform(0, 14.9, 60)
    pieces = np.stack([np.zeros(60), away, np.ones(60), away], axis=1)
    hits = SegmentGrid.of(pieces, np.arange(60, dtype=np.int32), np.zeros(60, np.float32)).near(np.array([0.5, 0.0]), 15.0)
    assert np.allclose(hits.distance, np.sort(away)[:MOST_HITS])


def test_a_lane_that_nothing_leads_to_is_found_before_its_start():
    hits = GRAPH.near(np.array([-90.0 - BEYOND + 8, -1.75]), 1.0)
    assert hits.lane.tolist() == [0]
    assert np.isclose(hits.s[0], 8 - BEYOND, atol=1e-3)


def test_nearest_heeds_the_heading():
    lane, numbers = GRAPH.nearest(np.array([[-50.0, 0.1], [-50.0, 0.1]]), np.array([0.0, np.pi]), 5.0, np.pi / 4)
    assert lane.tolist() == [0, 6]
    assert np.allclose(numbers[:, 3], [1.85, 1.65], atol=1e-3)
    assert np.isinf(GRAPH.distance_to_lanes(np.array([[500.0, 0.0]]))).all()


def test_bicycle_lanes_and_lane_drops():
    roads = scenes.road_map([[(0, 0), (50, 0)], [(0, 3.5), (50, 3.5)], [(50, 0), (90, 0)]], links=[(0, 2)], neighbours=[(1, 0)])
    graph = LaneGraph.of(roads)
    assert graph.leaves_map.tolist() == [False, False, True]  # lane 1 is dropped, but one can change to lane 0
    roads.kind[0] = LaneKind.BIKE
    graph = LaneGraph.of(roads)
    assert graph.usable.tolist() == [False, True, True]
    assert graph.leaves_map.tolist() == [False, True, True]
    assert graph.change[1].tolist() == [NO_LANE, NO_LANE]
    assert len(graph.predecessors[2]) == 0
