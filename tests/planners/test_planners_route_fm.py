"""route_fm meets goals exactly, never drives backward, and tells its residuals apart from its base."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import wrap_angle
from drivegen.core.scenario import DT, Trajectories
from drivegen.planners.base import Planner, PlanRequests
from drivegen.planners.shared.fitting import encode
from drivegen.planners.shared.guidance import Guidance, guided
from drivegen.planners.shared.motion import GRID, Residuals, decode
from drivegen.planners.shared.noise import normals
from drivegen.planners.shared.paths import Frames
from drivegen.planners.shared.profile import COEFFICIENTS, base_speed, spline
from tests.planners.test_planners_contract import without_routes
from tests.planners.tiny import calm, examples, tiny

LOGS = examples()


@pytest.fixture(scope="module")
def planner() -> Planner:
    planner = tiny("route_fm")
    planner.fit([LOGS], LOGS[:4], 7, None, lambda line: None)
    return planner


def still(count: int) -> Residuals:
    """Residuals of zero: the base alone."""
    return Residuals(*(np.zeros((count, GRID), np.float32) for _ in range(3)))


def wild(count: int, seed: int) -> Residuals:
    """Residuals much larger than any that is learnt."""
    value, slope = spline(np.linspace(0, 1, GRID))
    random = np.random.default_rng(seed)
    along, across = random.normal(0, 0.5, (count, COEFFICIENTS)), random.normal(0, 0.2, (count, COEFFICIENTS))
    return Residuals(*(a.astype(np.float32) for a in (along @ slope.T, across @ value.T, across @ slope.T)))


def backward(motion: Trajectories) -> float:
    """The longest step against the heading [m]."""
    step = np.diff(motion.position, axis=-2)
    forward = np.stack([np.cos(motion.heading), np.sin(motion.heading)], axis=-1)[..., :-1, :]
    return float(-(step * forward).sum(-1).min())


def assert_meets_goals(motion: Trajectories, requests: PlanRequests) -> None:
    rows, last = np.arange(len(requests)), requests.goal_step
    np.testing.assert_allclose(motion.position[rows, last], requests.goal_position, atol=1e-3)
    np.testing.assert_allclose(wrap_angle(motion.heading[rows, last] - requests.goal_heading), 0, atol=1e-3)
    np.testing.assert_allclose(motion.speed[rows, last], requests.goal_speed, atol=1e-3)


def test_goals_are_met_exactly_with_and_without_a_route(planner: Planner) -> None:
    moving = LOGS.requests[~LOGS.requests.parked]
    assert (moving.route >= 0).all()
    for requests in (moving, without_routes(moving)):
        assert_meets_goals(planner.sample(LOGS.scenarios, requests), requests)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.booleans())
def test_wild_residuals_neither_miss_the_goal_nor_drive_backward(seed: int, routed: bool) -> None:
    requests = LOGS.requests[~LOGS.requests.parked]
    requests = requests if routed else without_routes(requests)
    motion = decode(Frames.of(requests), requests, wild(len(requests), seed), 101)
    motion.validate()
    assert_meets_goals(motion, requests)
    assert backward(motion) < 0.01


@pytest.mark.parametrize("way", [1.2, 3.0, 6.0])
def test_a_residual_across_does_not_swing_a_vehicle_about_on_a_short_way(way: float) -> None:
    moving = without_routes(LOGS.requests[~LOGS.requests.parked])
    ahead = moving.position + way * np.stack([np.cos(moving.heading), np.sin(moving.heading)], axis=1)
    stops = replace(moving, goal_position=ahead.astype(np.float32), goal_heading=moving.heading, goal_speed=0 * moving.speed)
    x = np.tile(np.linspace(0, 1, GRID, dtype=np.float32), (len(stops), 1))
    curves = Residuals(0 * x, np.sin(2 * np.pi * x) ** 2 / 2, np.pi * np.sin(4 * np.pi * x))  # half of its natural size, twice
    swung = np.abs(wrap_angle(decode(Frames.of(stops), stops, curves, 101).heading - stops.heading[:, None])).max()
    assert 0.005 < swung < 0.02 * way  # it bends with the way


def test_a_goal_that_is_not_ahead_stops_the_vehicle(planner: Planner) -> None:
    moving = LOGS.requests[~LOGS.requests.parked]
    behind = replace(moving, goal_position=moving.position - 3 * np.stack([np.cos(moving.heading), np.sin(moving.heading)], 1))
    behind = replace(behind, goal_s=np.full(len(behind), -3, np.float32), goal_speed=0 * behind.goal_speed)
    motion = planner.sample(LOGS.scenarios, behind)
    assert (np.hypot(*np.moveaxis(motion.position - behind.position[:, None], -1, 0)) < 0.05).all()
    assert backward(motion) <= 0


def test_beyond_the_goal_the_vehicle_drives_straight_on(planner: Planner) -> None:
    short = LOGS.requests[LOGS.requests.goal_step == 90]
    assert len(short) == 3
    motion = planner.sample(LOGS.scenarios, short)
    on = np.diff(motion.position[:, 90:], axis=1)
    np.testing.assert_allclose(np.hypot(on[..., 0], on[..., 1]), np.tile(short.goal_speed[:, None] * DT, 10), atol=1e-3)


def test_a_vehicle_that_stands_keeps_its_heading(planner: Planner) -> None:
    motion = planner.sample(LOGS.scenarios, LOGS.requests)
    stands = np.hypot(*np.moveaxis(np.diff(motion.position, axis=1), -1, 0)) < 1e-4
    turned = np.abs(wrap_angle(np.diff(motion.heading, axis=1)))
    assert stands.any()
    assert turned[stands].max() < 1e-3


def test_the_log_comes_back_from_its_own_residuals() -> None:
    moving = calm(LOGS[~LOGS.requests.parked])
    assert len(moving) > 8
    frames = Frames.of(moving.requests)
    found = encode(frames, moving.requests, moving.motion)
    assert found.usable.all()
    value, slope = spline(np.linspace(0, 1, GRID))
    curves = Residuals(*(a.astype(np.float32) for a in (found.along @ slope.T, found.across @ value.T, found.across @ slope.T)))
    again = decode(frames, moving.requests, curves, 101)
    away = np.hypot(*np.moveaxis(again.position - moving.motion.position, -1, 0))[moving.motion.valid]
    assert away.mean() < 0.05
    base = decode(frames, moving.requests, still(len(moving)), 101)
    assert np.hypot(*np.moveaxis(base.position - moving.motion.position, -1, 0))[moving.motion.valid].mean() > 0.2


@settings(max_examples=50, deadline=None)
@given(st.floats(1, 12), st.floats(0, 300), st.floats(0, 40), st.floats(0, 40))
def test_the_base_covers_the_distance_and_never_drives_backward(duration: float, distance: float, v0: float, v1: float) -> None:
    t = np.linspace(0, duration, 4001)
    v = np.array([base_speed(x, duration, distance, v0, v1) for x in t])
    assert v.min() >= 0
    assert np.trapezoid(v, t) == pytest.approx(distance, abs=1e-2 * max(v0, v1) * duration + 1e-6)
    if distance > 0.01 * (v0 + v1):
        assert v[0] == pytest.approx(v0, abs=1e-9)
        assert v[-1] == pytest.approx(v1, abs=1e-9)


def test_spline_curves_vanish_with_their_slope_at_both_ends() -> None:
    value, slope = spline(np.array([0.0, 1.0]))
    assert value.shape == (2, COEFFICIENTS)
    np.testing.assert_allclose(value, 0, atol=1e-9)
    np.testing.assert_allclose(slope, 0, atol=1e-8)


def test_noise_is_normal_and_depends_on_seed_and_stream_alone() -> None:
    seed = np.arange(20_000)
    noise = normals(seed, 16)
    np.testing.assert_allclose(noise.mean(axis=0), 0, atol=0.04)
    np.testing.assert_allclose(np.cov(noise.T), np.eye(16), atol=0.05)
    np.testing.assert_array_equal(noise[7:8], normals(seed[7:8], 16))
    assert abs(np.corrcoef(noise.ravel(), normals(seed, 16, 1).ravel())[0, 1]) < 0.01


def test_guided_motion_of_a_request_does_not_depend_on_the_others(planner: Planner) -> None:
    requests = LOGS.requests[~LOGS.requests.parked]

    def motion(some: PlanRequests) -> Trajectories:
        return guided(planner, some, 91, lambda motion, _: motion.position[:, 45].sum(-1), Guidance(last=2, inner=1, step=0.3))

    together = motion(requests)
    for b in (0, len(requests) // 2):
        np.testing.assert_array_equal(motion(requests[b : b + 1]).position[0], together.position[b])
