"""Routes, Frenet coordinates and matching on hand-made maps."""

import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.av2.maps import read_map
from drivegen.core.geometry import wrap_angle
from drivegen.core.roadmap import LaneKind
from drivegen.core.scenario import VehicleKind
from drivegen.roads.graph import LaneGraph
from drivegen.roads.routes import SPACING, feasible_routes, from_frenet, match_route, to_frenet
from tests import scenes
from tests.timing import cpu_seconds, yardstick

CROSSING = LaneGraph.of(scenes.crossing())
ROAD = LaneGraph.of(scenes.straight_road(300, 3))
REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[3] / "shared" / "data")) / "argoverse2"


def drivable(route):
    return np.abs(np.diff(route.heading)).max() <= 0.25


def test_all_three_ways_across_a_crossing_are_found_and_leave_the_map():
    routes = feasible_routes(CROSSING, np.array([-40.0, -1.5]), 0.05, 10.0, 150.0)
    assert {route.lanes for route in routes} == {(0, 8, 4), (0, 9, 5), (0, 10, 7)}
    for route in routes:
        assert np.isfinite(route.exit_s)
        assert route.length >= 145
        assert drivable(route)
        assert np.allclose(np.hypot(*np.diff(route.line, axis=0).T), SPACING, atol=0.02)
        assert abs(to_frenet(route, np.array([[-40.0, -1.5]]))[0, 0]) < 0.05
    left = next(route for route in routes if route.lanes[1] == 9)
    assert np.isclose(left.turned[-1], np.pi / 2, atol=0.05)


def test_lane_changes_go_to_legal_neighbours_and_are_smooth():
    routes = feasible_routes(ROAD, np.array([20.0, 3.5]), 0.0, 10.0, 150.0)
    assert [route.lanes for route in routes] == [(1,), (1, 2), (1, 0)]
    assert [route.shift[-1] for route in routes] == [0, 1, -1]
    for route, y in zip(routes, (3.5, 7.0, 0.0), strict=True):
        assert np.isclose(route.line[0, 1], 3.5, atol=0.05)
        assert np.isclose(route.line[-1, 1], y, atol=0.05)
        assert np.abs(np.diff(route.heading)).max() < 0.03


def test_two_changes_reach_the_far_lane():
    ends = {
        round(float(route.line[-1, 1]), 1): route.lane_changes for route in feasible_routes(ROAD, np.zeros(2), 0.0, 8.0, 150.0)
    }
    assert ends == {0.0: 0, 3.5: 1, 7.0: 2}


def test_a_vehicle_between_lanes_may_be_on_both():
    routes = feasible_routes(ROAD, np.array([20.0, 1.75]), 0.0, 10.0, 100.0)
    assert {route.lanes[0] for route in routes if route.lane_changes == 0} == {0, 1}


def test_a_vehicle_before_a_cropped_map_has_a_route_onto_it():
    routes = feasible_routes(CROSSING, np.array([-102.0, -1.75]), 0.0, 8.0, 100.0)
    assert routes
    assert np.allclose(routes[0].line[0], (-102, -1.75), atol=0.01)


def test_a_vehicle_far_from_lanes_has_no_route():
    assert feasible_routes(CROSSING, np.array([60.0, 60.0]), 0.0, 5.0, 100.0) == []


def test_a_lane_drop_ends_the_route_on_it():
    roads = scenes.road_map([[(0, 0), (50, 0)], [(0, 3.5), (50, 3.5)], [(50, 0), (90, 0)]], links=[(0, 2)], neighbours=[(1, 0)])
    routes = feasible_routes(LaneGraph.of(roads), np.array([5.0, 3.5]), 0.0, 6.0, 120.0)
    by_lanes = {route.lanes: route for route in routes}
    assert by_lanes[(1,)].length == pytest.approx(45, abs=1)
    assert not np.isfinite(by_lanes[(1,)].exit_s)
    assert np.isfinite(by_lanes[(1, 0, 2)].exit_s)
    assert by_lanes[(1, 0, 2)].exit_s == pytest.approx(85, abs=1.5)


@pytest.mark.parametrize("noise", [-1e-5, 0.0, 1e-5])
def test_of_two_ways_that_turn_alike_left_comes_first_whatever_the_last_bits_say(noise):
    ahead, left, right = [(0, 0), (50, 0)], [(50, 0), (90, 0), (150, 60 + noise)], [(50, 0), (90, 0), (150, -60)]
    for sides in ((left, right), (right, left)):
        roads = scenes.road_map([ahead, *sides], links=[(0, 1), (0, 2)])
        found = feasible_routes(LaneGraph.of(roads), np.array([10.0, 0.0]), 0.0, 10.0, 120.0)
        assert found[0].line[-1, 1] > 0 > found[1].line[-1, 1]


def with_bus_lanes(roads, *lanes):
    roads.kind[list(lanes)] = LaneKind.BUS
    return LaneGraph.of(roads)


def lanes_of(graph, y, kind=VehicleKind.CAR, x=20.0, reach=150.0):
    return {route.lanes for route in feasible_routes(graph, np.array([x, y]), 0.0, 10.0, reach, kind=kind)}


@pytest.mark.parametrize("y", [3.5, 2.2, 1.8])
def test_only_buses_change_onto_a_bus_lane(y):
    graph = with_bus_lanes(scenes.straight_road(300, 2), 0)
    assert lanes_of(graph, y) == {(1,)}
    assert lanes_of(graph, 3.5, VehicleKind.BUS) == {(1,), (1, 0)}


def test_who_is_on_a_bus_lane_may_go_on_along_it_or_leave_it():
    graph = with_bus_lanes(scenes.straight_road(300, 2), 0)
    assert lanes_of(graph, 0.0) == {(0,), (0, 1)}
    assert lanes_of(graph, 1.0) == {(0,), (1,)}  # both lanes fit
    assert lanes_of(with_bus_lanes(scenes.straight_road(300, 1), 0), 5.0) == {(0,)}  # beside the road, and there is no other


def test_who_joins_the_road_from_beside_a_bus_lane_joins_the_lane_for_cars():
    graph = with_bus_lanes(scenes.straight_road(300, 2), 0)
    assert lanes_of(graph, -5.0) == {(1,)}
    assert (0,) in lanes_of(graph, -5.0, VehicleKind.BUS)


FORK = [[(0, 0), (50, 0)], [(50, 0), (150, 0)], [(50, 0), (100, 20), (150, 50)]]


def test_where_a_lane_goes_on_as_a_bus_lane_cars_turn_off_or_stop():
    graph = with_bus_lanes(scenes.road_map(FORK, links=[(0, 1), (0, 2)]), 1)
    assert lanes_of(graph, 0.0) == {(0, 2)}
    assert lanes_of(graph, 0.0, VehicleKind.BUS) == {(0, 1), (0, 2)}
    assert lanes_of(graph, 0.0, x=0.0, reach=200.0) == {(0, 2)}
    graph = with_bus_lanes(scenes.road_map(FORK[:2], links=[(0, 1)]), 1)
    only = feasible_routes(graph, np.array([20.0, 0.0]), 0.0, 10.0, 100.0)
    assert [route.lanes for route in only] == [(0,)]
    assert only[0].length == pytest.approx(30, abs=1)


def test_a_logged_track_may_lie_on_a_bus_lane_and_goes_on_as_its_kind_may():
    graph = with_bus_lanes(scenes.road_map(FORK, links=[(0, 1), (0, 2)]), 1)
    x = np.arange(0.0, 90.0, 2.0)
    along = np.stack([x, np.zeros_like(x)], 1)
    assert match_route(graph, along, np.zeros_like(x)).lanes == (0, 1)
    early = along[:20], np.zeros(20)
    assert match_route(graph, *early).lanes == (0, 2)
    assert match_route(graph, *early, kind=VehicleKind.BUS).lanes == (0, 1)


def test_a_kinked_road_is_rounded():
    roads = scenes.road_map([[(0, 0), (30, 0)], [(30, 0), (30, 30)]], links=[(0, 1)])
    route = feasible_routes(LaneGraph.of(roads), np.zeros(2), 0.0, 5.0, 58.0)[0]
    assert drivable(route)
    assert np.hypot(*(route.line - (30, 0)).T).min() < 3.0  # a turning circle of 5 m cuts 2.1 m off the corner


def test_routes_are_the_same_whatever_was_asked_before():
    first = feasible_routes(CROSSING, np.array([-40.0, -1.5]), 0.05, 10.0, 150.0)
    assert len(first) > 1
    feasible_routes(CROSSING, np.array([1.75, -40.0]), 1.6, 10.0, 90.0)
    again = feasible_routes(CROSSING, np.array([-40.0, -1.5]), 0.05, 10.0, 150.0)
    assert all(np.array_equal(a.line, b.line) for a, b in zip(first, again, strict=True))


@settings(max_examples=50, deadline=None)
@given(s=st.floats(-10, 160), d=st.floats(-3, 3), way=st.integers(0, 2))
def test_frenet_coordinates_go_there_and_back(s, d, way):
    route = feasible_routes(CROSSING, np.array([-40.0, -1.75]), 0.0, 10.0, 150.0)[way]
    position, _ = from_frenet(route, np.array([s]), np.array([d]))
    assert np.allclose(to_frenet(route, position)[0], (s, d), atol=2e-3)


@settings(max_examples=30, deadline=None)
@given(way=st.sampled_from([(0, 8, 4), (0, 9, 5), (0, 10, 7), (2, 15, 7)]), speed=st.floats(4, 14), seed=st.integers(0, 10**6))
def test_a_noisy_track_is_matched_to_the_lanes_it_followed(way, speed, seed):
    track = scenes.drive(scenes.joined(CROSSING.map, *way), 25, speed, 101)
    noise = np.random.default_rng(seed).normal(0, 0.25, track.position.shape)
    route = match_route(CROSSING, track.position + noise, track.heading)
    assert route is not None
    ends = np.cumsum([CROSSING.length[lane] for lane in way])
    reached = 1 + int(np.searchsorted(ends, 25 + 10 * speed - 6))
    assert route.lanes[:reached] == way[:reached]
    assert np.abs(to_frenet(route, track.position)[:, 1]).max() < 0.6


def test_a_logged_lane_change_is_blended_where_it_happened():
    t = np.arange(101) * 0.1
    x = 20 + 12 * t
    y = 3.5 * np.clip((t - 4) / 3, 0, 1) ** 2 * (3 - 2 * np.clip((t - 4) / 3, 0, 1))
    heading = np.arctan2(np.gradient(y), np.gradient(x))
    route = match_route(ROAD, np.stack([x, y], 1), heading)
    assert route.lanes == (0, 1)
    assert route.shift[-1] == 1
    assert np.abs(to_frenet(route, np.stack([x, y], 1))[:, 1]).max() < 0.6


@pytest.mark.parametrize("offset", [30.0, 6.0])
def test_a_track_off_the_lanes_matches_no_route(offset):
    x = np.linspace(20, 80, 60)
    assert match_route(ROAD, np.stack([x, np.full(60, -offset)], 1), np.zeros(60)) is None


def test_a_track_against_traffic_matches_no_route():
    x = np.linspace(80, 20, 60)
    assert match_route(ROAD, np.stack([x, np.zeros(60)], 1), np.full(60, np.pi)) is None


def test_a_track_that_stands_has_a_route_ahead_and_none_behind_it():
    place, heading = np.tile([30.0, -1.75], (5, 1)), np.zeros(5)
    assert match_route(ROAD, place, heading) is not None
    assert match_route(ROAD, place, heading, beyond=0.0) is None


@pytest.mark.parametrize("steps", [1, 2, 50])
def test_a_parked_car_on_a_lane_is_matched_to_it(steps):
    route = match_route(ROAD, np.full((steps, 2), (50.0, 3.7)), np.full(steps, 0.02))
    assert route.lanes == (1,)
    assert np.allclose(route.line[0], (50, 3.5), atol=0.05)


def _routes_of_all(graph, points, headings):
    return [feasible_routes(graph, point, float(heading), 12.0, 150.0) for point, heading in zip(points, headings, strict=True)]


@pytest.mark.skipif(not REAL.exists(), reason="real Argoverse 2 data is not there")
def test_real_maps_give_drivable_routes_in_a_millisecond():
    asked, kept, spent = 0, 0, 0.0
    for file in sorted(REAL.rglob("log_map_archive_*.json")):
        graph = LaneGraph.of(read_map(file.read_bytes(), str(file)))
        lanes = np.flatnonzero(graph.usable)
        rows = graph.line.start[lanes] + 1
        headings = np.arctan2(*(graph.line.points[rows] - graph.line.points[rows - 1]).T[::-1])
        find = partial(_routes_of_all, graph, graph.line.points[rows], headings)
        found = find()  # compiles
        spent, asked = spent + cpu_seconds(find, times=2), asked + len(rows)
        for lane, row, heading, routes in zip(lanes, rows, headings, found, strict=True):
            kept += any(lane in route.lanes[:2] for route in routes)
            for route in routes:
                assert np.hypot(*(route.line[0] - graph.line.points[row])) < 3.1
                assert np.abs(np.diff(route.heading)).max() < 0.5
                assert abs(wrap_angle(route.heading[0] - heading)) < 1.2
    assert kept / asked > 0.95, "a vehicle on a lane should have a route along it"
    assert spent / asked < 0.03 * yardstick(), "routes should take about a millisecond a vehicle"
