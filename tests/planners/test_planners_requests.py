"""Plan requests tell what is ahead on the route, and join without mixing routes up."""

import numpy as np
import pytest

from drivegen.core.scenario import Scenario
from drivegen.core.signals import Signals, SignalState
from drivegen.planners.base import ROUTE_POINTS, Examples, PlanRequests
from drivegen.planners.shared.motion import GRID, Residuals, decode
from drivegen.planners.shared.paths import Frames
from drivegen.planners.shared.requests import Goals, examples_from_logs, moved, plan_requests
from drivegen.roads.graph import LaneGraph
from drivegen.roads.routes import feasible_routes
from tests.scenes import crossing, drive, joined, scenario, stack, straight_road


def ahead(scene: Scenario, reach: float = 120.0) -> PlanRequests:
    """Requests of vehicle 0 for two goals on its first route and for one without a route."""
    vehicle = scene.vehicles[0]
    graph = LaneGraph.of(scene.map)
    route = feasible_routes(graph, vehicle.position, float(vehicle.heading), float(vehicle.speed), reach)[0]
    end = np.array([route.line[30], route.line[40], route.line[40]])
    zeros = np.zeros(3, np.int32)
    s = np.array([30.0, 40.0, 0.0])
    goals = Goals(zeros, zeros, end, np.zeros(3), np.ones(3) * 5, zeros + 100, np.array([0, 0, -1]), s, np.zeros(3))
    return plan_requests([scene], [route], goals, np.arange(3))


def on_straight(*motions: tuple[float, float, float]) -> Scenario:
    """Cars (start, lateral offset, speed) on a straight road of two lanes."""
    cars = []
    for start, offset, speed in motions:
        car = drive(np.array([[0.0, 0.0], [290.0, 0.0]]), start, speed, 101)
        car.position[:, 1] += offset
        cars.append(car)
    return scenario(straight_road(), stack(cars))


def test_the_leader_is_the_nearest_ahead_in_its_way_bumper_to_bumper() -> None:
    requests = ahead(on_straight((10, 0, 10), (60, 0, 4), (40, 0.3, 6), (30, 3.5, 8), (2, 0, 9)))
    assert requests.leader_gap[:2] == pytest.approx([30 - 4.6] * 2, abs=0.05)
    assert requests.leader_speed[:2] == pytest.approx([6, 6], abs=0.05)
    assert requests.leader_gap[2] == np.inf  # no route, no leader


def test_without_anyone_ahead_there_is_no_leader_and_no_stop() -> None:
    requests = ahead(on_straight((100, 0, 10), (60, 0, 4), (140, 3.5, 6)))
    assert np.isinf(requests.leader_gap).all()
    assert not requests.leader_speed.any()
    assert np.isinf(requests.stop_s).all()


@pytest.mark.parametrize(
    ("state", "distance"), [(SignalState.RED, 50.0), (SignalState.YELLOW, 50.0), (SignalState.GREEN, np.inf)]
)
def test_the_next_red_or_yellow_signal_is_told(state: SignalState, distance: float) -> None:
    roads = crossing()
    lanes = np.arange(8, 20, dtype=np.int32)
    signals = Signals(lanes, np.full((12, 101), state, np.uint8))
    requests = ahead(scenario(roads, stack([drive(joined(roads, 0, 8, 4), 30, 5, 101)]), signals=signals))
    assert requests.stop_s[0] == pytest.approx(distance, abs=1.0)


def test_a_signal_is_no_stop_for_who_is_past_its_line() -> None:
    roads = crossing()
    signals = Signals(np.arange(8, 20, dtype=np.int32), np.full((12, 101), SignalState.RED, np.uint8))
    requests = ahead(scenario(roads, stack([drive(joined(roads, 0, 8, 4), 84, 5, 101)]), signals=signals), reach=60.0)
    assert np.isinf(requests.stop_s).all()


def test_a_route_that_begins_elsewhere_counts_as_none() -> None:
    scene = on_straight((10, 0, 10))
    route = feasible_routes(LaneGraph.of(scene.map), np.array([50.0, 0.0]), 0.0, 10.0, 100.0)[0]
    zero = np.zeros(1, np.int32)
    goals = Goals(zero, zero, np.array([[90.0, 0.0]]), np.zeros(1), np.ones(1), zero + 100, zero, np.ones(1) * 40, np.zeros(1))
    assert plan_requests([scene], [route], goals, np.zeros(1, np.int64)).route[0] == -1


def test_route_lines_are_padded_straight_on() -> None:
    requests = ahead(on_straight((10, 0, 10)))
    assert requests.route_line.shape == (1, ROUTE_POINTS, 2)
    np.testing.assert_allclose(requests.route_line[0, :, 1], 0, atol=1e-3)
    np.testing.assert_allclose(np.diff(requests.route_line[0, :, 0]), 1, atol=1e-2)


@pytest.mark.parametrize("metres", [448.0, 520.0, 560.0])
def test_a_goal_beyond_the_table_of_its_route_is_reached_without_braking(metres: float) -> None:
    scene = scenario(straight_road(1500.0), stack([drive(np.array([[0.0, 0.0], [1400.0, 0.0]]), 50, 45, 101)]))
    route = feasible_routes(LaneGraph.of(scene.map), scene.vehicles.position[0], 0.0, 45.0, 700.0)[0]
    zero, far = np.zeros(1, np.int32), np.array([metres])
    goals = Goals(zero, zero, np.array([[50.0 + metres, 0.0]]), zero, 2 * far / 10 - 45, zero + 100, zero, far, np.zeros(1))
    requests = plan_requests([scene], [route], goals, np.zeros(1, np.int64))
    nothing = np.zeros((1, GRID), np.float32)
    x, y = decode(Frames.of(requests), requests, Residuals(nothing, nothing, nothing), 101).position[0].T
    assert np.diff(x).min() > 4.4
    assert x[-1] == pytest.approx(50 + metres, abs=1e-3)
    assert np.abs(y).max() < 1e-3
    assert moved(requests, -far, np.ones(1), -far).goal_position.tolist() == requests.goal_position.tolist()


def logged(number: int) -> Examples:
    roads = crossing()
    motions = [drive(joined(roads, 0, 8, 4), 5 + number, 8, 101), drive(joined(roads, 2, 15, 7), 30, 6, 101)]
    motions[1].valid[40:] = False  # seen too little
    return examples_from_logs([scenario(roads, stack(motions), f"scene-{number}")], [LaneGraph.of(roads)], 0.8, 7)


def test_logged_tracks_become_requests_for_their_own_end() -> None:
    requests = logged(0).requests
    assert len(requests) == 1
    assert requests.goal_s[0] == pytest.approx(80, abs=0.2)
    assert requests.goal_d[0] == pytest.approx(0, abs=0.05)
    assert requests.goal_step[0] == 100
    assert requests.goal_speed[0] == pytest.approx(8, abs=0.01)


def test_joined_examples_are_those_of_the_parts() -> None:
    parts = [logged(k) for k in range(3)]
    whole = Examples.join(parts)
    assert [len(whole), len(whole.scenarios)] == [3, 3]
    for k, part in enumerate(parts):
        assert whole.scenarios[whole.requests.scenario[k]].scenario_id == f"scene-{k}"
        np.testing.assert_array_equal(whole.requests.route_line[whole.requests.route[k]], part.requests.route_line[0])
        np.testing.assert_array_equal(whole.motion.position[k], part.motion.position[0])
    assert len(Examples.join([])) == 0
