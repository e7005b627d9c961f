"""poly_fm meets goals exactly on paths of its own, learns bends that a Bezier curve lacks, and sees the lanes by its way."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import rotate, wrap_angle
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.planners._poly_fm.bends import Bent, bent_frames, encode, straight_on
from drivegen.planners._poly_fm.net import own_features
from drivegen.planners._poly_fm.polylines import MOST, PIECE, POINTS, SCALE, surroundings
from drivegen.planners.base import Planner, PlanRequests
from drivegen.planners.poly_fm import GROUPS
from drivegen.planners.shared.latent import expanded, principal
from drivegen.planners.shared.motion import GRID, decode
from drivegen.planners.shared.profile import spline
from tests.planners.test_planners_contract import without_routes
from tests.planners.test_planners_route_fm import assert_meets_goals, backward
from tests.planners.tiny import calm, examples, tiny

LOGS = examples()
MOVING = LOGS[~LOGS.requests.parked]


@pytest.fixture(scope="module")
def planner() -> Planner:
    planner = tiny("poly_fm")
    planner.fit([LOGS], LOGS[:4], 7, None, lambda line: None)
    return planner


def decoded(requests: PlanRequests, found: Bent) -> Trajectories:
    value, slope = spline(np.linspace(0, 1, GRID))
    pace, x, y = (c.astype(np.float32) for c in (found.along @ slope.T, found.bend_x @ value.T, found.bend_y @ value.T))
    return decode(bent_frames(requests, x, y), requests, straight_on(len(requests), pace), 101)


def error(motion: Trajectories, log: Trajectories) -> float:
    """Mean distance to the logs at seen steps [m]."""
    return float(np.hypot(*np.moveaxis(motion.position - log.position, -1, 0))[log.valid].mean())


def test_goals_are_met_exactly_and_routes_make_no_difference(planner: Planner) -> None:
    with_route = planner.sample(LOGS.scenarios, MOVING.requests)
    without = planner.sample(LOGS.scenarios, without_routes(MOVING.requests))
    assert_meets_goals(with_route, MOVING.requests)
    np.testing.assert_array_equal(with_route.position, without.position)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
@example(2140)  # the farthest that was met: 7 cm
def test_bends_twice_as_wild_as_learnt_neither_miss_the_goal_nor_drive_backward(seed: int) -> None:
    random, value = np.random.default_rng(seed), spline(np.linspace(0, 1, GRID))
    found = encode(MOVING.requests, MOVING.motion)
    wild = []
    for name in GROUPS:
        basis = principal(getattr(found, name), 6, name)
        drawn = random.normal(0, 2, (len(MOVING), 6)).astype(np.float32)
        wild.append(expanded(drawn, basis, name, value[name == "along"]))
    pace, x, y = wild
    motion = decode(bent_frames(MOVING.requests, x, y), MOVING.requests, straight_on(len(MOVING), pace), 101)
    motion.validate()
    assert_meets_goals(motion, MOVING.requests)
    assert backward(motion) < 0.15


def test_the_log_comes_back_from_its_own_bends_and_not_from_the_bezier_curve() -> None:
    slow = examples(speed=(2.5, 4.5))
    calmly = calm(slow[~slow.requests.parked])
    found = encode(calmly.requests, calmly.motion)
    assert found.usable.all()
    none = replace(found, bend_x=0 * found.bend_x, bend_y=0 * found.bend_y)
    assert error(decoded(calmly.requests, found), calmly.motion) < 0.15
    assert error(decoded(calmly.requests, none), calmly.motion) > 0.3


def turned(scene: Scenario, requests: PlanRequests, angle: float, shift: np.ndarray) -> tuple[Scenario, PlanRequests]:
    """Scene and requests turned about the origin and moved."""

    def moved(points: np.ndarray) -> np.ndarray:
        return (rotate(points.astype(np.float64), angle) + shift).astype(np.float32)

    lines = replace(scene.map.centreline, points=moved(scene.map.centreline.points))
    return replace(scene, map=replace(scene.map, centreline=lines)), replace(
        requests,
        position=moved(requests.position),
        goal_position=moved(requests.goal_position),
        heading=wrap_angle(requests.heading + angle).astype(np.float32),
        goal_heading=wrap_angle(requests.goal_heading + angle).astype(np.float32),
    )


def test_the_network_is_told_the_same_wherever_the_scene_lies() -> None:
    requests = MOVING.requests[MOVING.requests.scenario == 0]
    scene, there = turned(LOGS.scenarios[0], requests, 2.0, np.array([300.0, -80.0]))
    np.testing.assert_allclose(own_features(there), own_features(requests), atol=1e-3)
    here = [surroundings([s], r).reshape(-1, MOST, PIECE) for s, r in ((LOGS.scenarios[0], requests), (scene, there))]
    by_distance = [np.sort(a[..., 4 * POINTS + 3], axis=1) for a in here]
    np.testing.assert_allclose(by_distance[0], by_distance[1], atol=1e-3)
    np.testing.assert_allclose(here[0].sum(axis=1), here[1].sum(axis=1), atol=0.05)


def test_pieces_are_those_nearest_to_the_way_in_the_vehicle_s_frame() -> None:
    request = MOVING.requests[:1]
    told = surroundings(LOGS.scenarios, request).reshape(MOST, PIECE)
    away = told[:, 4 * POINTS + 3]
    there = told[:, -1] > 0
    assert there.any()
    assert (np.diff(away[there]) >= 0).all()
    assert away[0] * SCALE < 1.5  # the vehicle drives on a lane
    nearest = np.arctanh(told[0, : 2 * POINTS].reshape(-1, 2)) * SCALE
    lines = LOGS.scenarios[0].map.centreline
    world = rotate(nearest.astype(np.float64), float(request.heading[0])) + request.position[0]
    gaps = [np.hypot(*(lines.points - p).T).min() for p in world]
    assert max(gaps) < 10  # its points lie on a centreline, whose own are farther apart than that
    assert not surroundings(LOGS.scenarios, request[:0]).size
