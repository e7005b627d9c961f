from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.crop import Cropper, take_lanes
from drivegen.core.geometry import Polylines, resample
from tests.scenes import crossing, straight_road

ROADS = replace(crossing(whole=True), yields_to=np.array([[8, 11], [8, 17], [9, 14], [13, 8]], np.int32))
CROPPER = Cropper(ROADS)


@settings(max_examples=50, deadline=None)
@given(st.floats(-120, 120), st.floats(-120, 120), st.floats(1, 150))
def test_lanes_within_the_radius_are_kept_whole_and_far_ones_are_not(x, y, radius):
    cut, kept = CROPPER.around(np.array([[x, y]]), radius)
    assert np.array_equal(cut.lane_id, ROADS.lane_id[kept])
    for i in range(len(ROADS)):
        gap = np.hypot(*(resample(ROADS.centreline[i], 0.5) - [x, y]).T).min()
        if gap < radius - 6:  # lines are tested every 10 m
            assert i in kept
        if i in kept:
            assert gap <= radius + 0.1
            assert np.array_equal(cut.centreline[int(np.searchsorted(kept, i))], ROADS.centreline[i])


@settings(max_examples=50, deadline=None)
@given(st.sets(st.integers(0, len(ROADS) - 1), min_size=1))
def test_a_cut_map_is_sound_and_counts_the_links_it_lost(lanes):
    kept = np.array(sorted(lanes))
    cut = take_lanes(ROADS, kept)
    cut.validate()
    within = {(a, b) for a, b in ROADS.links.tolist() if a in lanes and b in lanes}
    across = {(a, b) for a, b in ROADS.links.tolist() if (a in lanes) != (b in lanes)}
    assert {(int(kept[a]), int(kept[b])) for a, b in cut.links} == within
    assert cut.dangling == len(across)
    order = [pair for pair in ROADS.yields_to.tolist() if lanes.issuperset(pair)]
    assert kept[cut.yields_to].tolist() == order
    assert set(kept[cut.stop_lane].tolist()) == set(ROADS.stop_lane.tolist()) & lanes
    lost = {(a, 1) for a, b in ROADS.links.tolist() if b not in lanes} | {
        (b, 0) for a, b in ROADS.links.tolist() if a not in lanes
    }
    assert {(int(kept[i]), int(end)) for i, end in np.argwhere(cut.cut)} == {(i, end) for i, end in lost if i in lanes}
    again = take_lanes(cut, np.arange(len(cut)))
    assert np.array_equal(again.cut, cut.cut)  # what is cut stays so


def test_neighbours_that_are_cut_off_are_no_neighbours():
    roads = straight_road(100, 3)
    cut = take_lanes(roads, np.array([0, 1]))
    assert cut.neighbour.tolist() == [[1, -1], [-1, 0]]
    assert cut.may_change.tolist() == [[True, False], [False, True]]


def test_an_area_is_near_also_where_only_the_edge_that_closes_it_is():
    roads = straight_road(1000, 1)
    area = np.array([[0.0, 100.0], [0.0, 900.0], [1000.0, 900.0], [1000.0, 100.0]])  # closes 100 m beside the road
    roads = replace(roads, drivable=Polylines.of([area]), crossings=Polylines.of([area]))
    cut, _ = Cropper(roads).around(np.array([[500.0, 0.0]]), 110.0)
    assert len(cut.drivable) == len(cut.crossings) == 1
    assert not len(Cropper(roads).around(np.array([[500.0, 0.0]]), 90.0)[0].drivable)


def test_a_path_keeps_what_lies_along_it_and_nothing_is_near_a_far_place():
    roads = straight_road(1000, 1)
    cut, _ = Cropper(roads).around(np.array([[0.0, 500.0], [500.0, 30.0]]), 40.0)
    assert len(cut) == 1
    none, kept = Cropper(roads).around(np.array([[0.0, 500.0]]), 40.0)
    assert len(none) == len(kept) == len(none.drivable) == 0
