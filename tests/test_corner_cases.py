"""Encounters, knowledge and pressure by hand cases and properties."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.scenario import DT, Trajectories
from drivegen.corner_cases.encounters import Behaviour, Direction, encounters
from drivegen.corner_cases.knowledge import SHAPE, Knowledge, wilson
from drivegen.corner_cases.pressure import PressureSettings, lean, risk
from drivegen.corner_cases.rounds import Drive, _to_the_end, taught
from drivegen.corner_cases.summary import RoundSummary
from drivegen.world.outcome import NO_PARTNER, CollisionKind, DrivingOutcome

CAR = np.array([4.5, 1.9, 1.5], np.float32)
PRESSURE = PressureSettings(strength=2.0, reach=10.0, max_ratio=8.0, reaction_time=1.5)


def drive(start: tuple[float, float], heading: float, speed: float, steps: int = 101) -> Trajectories:
    time = np.arange(steps) * DT
    velocity = speed * np.array([np.cos(heading), np.sin(heading)])
    return Trajectories(
        (np.array(start) + time[:, None] * velocity).astype(np.float32),
        np.full(steps, heading, np.float32),
        np.repeat(velocity[None], steps, 0).astype(np.float32),
        np.ones(steps, bool),
    )


def together(*motions: Trajectories) -> Trajectories:
    return Trajectories.joined([motion[np.newaxis] for motion in motions])


def swerving(turned: float, shifted: float, steps: int = 101) -> Trajectories:
    """At 8 m/s; in the last three seconds its heading changes by `turned` [rad] and it gets `shifted` [m] to the left."""
    late = np.clip((np.arange(steps) - (steps - 31)) / 30, 0, 1)
    heading = turned * late
    velocity = 8 * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    position = np.cumsum(velocity, axis=0) * DT + np.stack([np.zeros(steps), shifted * late], axis=-1)
    arrays = (position, heading, velocity)
    return Trajectories(*(a.astype(np.float32) for a in arrays), np.ones(steps, bool))


def test_the_closest_approach_is_that_of_all_pairs_of_discs():
    random = np.random.default_rng(5)

    def strays(*shape: int) -> Trajectories:
        position = np.cumsum(random.normal(0, 1, (*shape, 101, 2)), axis=-2) + random.normal(0, 20, (*shape, 1, 2))
        heading, velocity = random.uniform(-3, 3, (*shape, 101)), random.normal(0, 5, (*shape, 101, 2))
        return Trajectories(*(a.astype(np.float32) for a in (position, heading, velocity)), random.random((*shape, 101)) < 0.7)

    def discs(motion: Trajectories, size: np.ndarray) -> np.ndarray:
        ahead = np.stack([np.cos(motion.heading), np.sin(motion.heading)], axis=-1)
        reach = np.maximum(size[..., 0] - size[..., 1], 0)[..., None, None] / 2
        return np.stack([motion.position + k * reach * ahead for k in (-1, 0, 1)], axis=-2)

    target, social = strays(20), strays(20, 6)
    own, others = random.uniform(1, 5, (20, 3)).astype(np.float32), random.uniform(1, 9, (20, 6, 3)).astype(np.float32)
    apart = discs(target, own)[:, None, :, :, None] - discs(social, others)[..., None, :, :]
    gap = np.hypot(apart[..., 0], apart[..., 1]).min(axis=(-1, -2)) - (own[:, None, 1] + others[..., 1])[..., None] / 2
    gap = np.where(target.valid[:, None] & social.valid, np.maximum(gap, 0), np.inf)
    met = encounters(target, own, social, others)
    np.testing.assert_allclose(met.gap, gap.min(axis=-1), atol=1e-4)
    np.testing.assert_allclose(np.take_along_axis(gap, met.step[..., None].astype(int), -1)[..., 0], met.gap, atol=1e-4)


def test_a_car_from_the_right_meets_the_target_where_their_paths_cross():
    target = drive((0, 0), 0.0, 10.0)
    crossing = drive((50, -50), np.pi / 2, 10.0)
    met = encounters(target, CAR, together(crossing), CAR[None])
    assert met.step[0] == pytest.approx(50, abs=3)
    assert met.gap[0] == 0
    assert met.direction[0] == Direction.FROM_RIGHT
    assert met.behaviour[0] == Behaviour.STRAIGHT
    assert met.speed_bin[0] == 3  # sqrt(200) = 14.1 m/s


def test_oncoming_standing_and_absent_vehicles_are_told_apart():
    target = drive((0, 0), 0.0, 10.0)
    oncoming, parked = drive((100, 3.5), np.pi, 10.0), drive((60, -3.5), 0.0, 0.0)
    absent = Trajectories.empty(101)
    met = encounters(target, CAR, together(oncoming, parked, absent), np.stack([CAR] * 3))
    assert list(met.met) == [True, True, False]
    assert met.direction[0] == Direction.OPPOSITE
    assert met.behaviour[1] == Behaviour.STANDING
    assert met.gap[0] == pytest.approx(3.5 - 1.9, abs=0.1)
    assert np.isinf(met.gap[2])


def test_a_braking_leader_is_seen_to_brake():
    target = drive((0, 0), 0.0, 10.0)
    time = np.arange(101) * DT
    speed = np.maximum(10 - 2 * time, 0)
    position = np.stack([20 + np.concatenate([[0], np.cumsum(speed[:-1] * DT)]), np.zeros(101)], -1)
    leader = Trajectories(
        position.astype(np.float32),
        np.zeros(101, np.float32),
        np.stack([speed, np.zeros(101)], -1).astype(np.float32),
        np.ones(101, bool),
    )
    met = encounters(target, CAR, together(leader), CAR[None])
    assert met.behaviour[0] == Behaviour.BRAKING
    assert met.direction[0] == Direction.SAME


@pytest.mark.parametrize(
    ("turned", "shifted", "behaviour"),
    [
        (0.0, 0.0, Behaviour.STRAIGHT),
        (0.5, 0.0, Behaviour.TURNING_LEFT),
        (-0.5, 0.0, Behaviour.TURNING_RIGHT),
        (0.0, 2.0, Behaviour.SHIFTING_LEFT),
        (0.0, -2.0, Behaviour.SHIFTING_RIGHT),
        (0.5, -4.0, Behaviour.TURNING_LEFT),  # the stronger sign
        (0.2, 0.0, Behaviour.SHIFTING_LEFT),  # three seconds at 8 m/s, a little aslant
    ],
)
def test_turns_and_changes_of_lane_are_told_apart(turned, shifted, behaviour):
    social = swerving(turned, shifted)
    standing = drive((float(social.position[-1, 0]) + 8.0, float(social.position[-1, 1])), 0.0, 0.0)
    met = encounters(standing, CAR, together(social), CAR[None])
    assert met.step[0] == 100
    assert Behaviour(met.behaviour[0]) is behaviour


def test_who_comes_up_from_behind_teaches_nothing():
    target = drive((0, 0), 0.0, 5.0)
    follower, leader = drive((-40, 0), 0.0, 10.0), drive((40, 0), 0.0, 1.0)
    met = encounters(target, CAR, together(follower, leader), np.stack([CAR] * 2))
    assert met.behind.tolist() == [True, False]
    assert met.direction.tolist() == [Direction.SAME, Direction.SAME]
    knowledge = Knowledge.none(4.0).with_outcomes(met, np.array([True, True]), reach=10.0)
    assert (knowledge.encounters.sum(), knowledge.collisions.sum()) == (1, 1)
    assert knowledge.encounters[met.speed_bin[1], Direction.SAME, met.behaviour[1]] == 1
    risks = risk(met, knowledge, PRESSURE)
    assert risks[0] == pytest.approx(0.1 * knowledge.base_rate)
    assert risks[1] > 5 * risks[0]


def test_a_cell_never_met_leans_on_what_is_known_of_its_features():
    seen, hit = np.zeros(SHAPE, np.int64), np.zeros(SHAPE, np.int64)
    seen[3, Direction.FROM_RIGHT, Behaviour.STRAIGHT] = seen[0, Direction.SAME, Behaviour.BRAKING] = 50
    hit[3, Direction.FROM_RIGHT, Behaviour.STRAIGHT] = 40
    p = Knowledge(seen, hit, 4.0).probability()
    never_met = p[:, :, Behaviour.TURNING_LEFT]
    deadly, half, harmless = never_met[3, Direction.FROM_RIGHT], never_met[3, Direction.SAME], never_met[0, Direction.SAME]
    assert deadly > 1.5 * half > 1.5 * harmless


def test_a_base_rate_is_smoothed_by_half_a_collision_in_one_encounter():
    seen, hit = np.zeros(SHAPE, np.int64), np.zeros(SHAPE, np.int64)
    seen[0, 0, 0], hit[0, 0, 0] = 9, 2
    assert Knowledge(seen, hit, 4.0).base_rate == pytest.approx(0.25)
    assert Knowledge.none(4.0).base_rate == 0.5


def test_a_round_teaches_what_the_driver_might_have_prevented_and_of_whom():
    kinds = (
        CollisionKind.FRONT,
        CollisionKind.FRONT,
        CollisionKind.HIT_FROM_BEHIND,
        CollisionKind.HIT_IN_SIDE,
        CollisionKind.NONE,
    )
    runs = drive((0, 0), 0.0, 5.0)[np.newaxis][np.zeros(5, int)]
    outcome = DrivingOutcome(
        np.array(kinds, np.uint8), np.array([40, 5, 40, 40, -1], np.int16), np.array([1, 1, 2, 2, NO_PARTNER], np.int32),
        np.zeros(5, np.bool_), runs, np.zeros(5, np.uint8), np.zeros(5, np.bool_), *np.zeros((6, 5), np.float32),
    )  # fmt: skip
    choice = SimpleNamespace(scenario=SimpleNamespace(vehicles=range(3)))
    found = taught(Drive(None, runs, outcome), choice)
    assert found.tolist() == [[True, False], [False, False], [False, False], [False, True], [False, False]]


def test_where_a_run_ended_the_target_is_left_standing_unless_it_left_the_map():
    run = drive((0, 0), 0.0, 10.0)[np.newaxis][[0, 0]]
    run.valid[:, 41:] = False
    longest = run.padded(121)  # one that was driven beside them is longer
    outcome = replace(DrivingOutcome.none(121), motion=longest, left_map=np.array([False, True]))
    stays = _to_the_end(SimpleNamespace(target=run, outcome=outcome))
    assert stays.valid[0].all()
    np.testing.assert_array_equal(stays.valid[1], run.valid[1])
    np.testing.assert_array_equal(stays.position[0, :41], run.position[0, :41])
    np.testing.assert_allclose(stays.position[0, 41:], np.tile([40.0, 0.0], (60, 1)), atol=1e-4)
    assert (stays.speed[0, :41] == 10).all()
    assert (stays.speed[0, 41:] == 0).all()


def test_knowledge_counts_every_encounter_and_ranks_the_deadly_feature_first():
    target = drive((0, 0), 0.0, 10.0)
    crossing, oncoming = drive((50, -50), np.pi / 2, 10.0), drive((100, 3.5), np.pi, 10.0)
    met = encounters(target, CAR, together(crossing, oncoming), np.stack([CAR] * 2))
    knowledge = Knowledge.none(strength=4.0)
    for _ in range(20):
        knowledge = knowledge.with_outcomes(met, np.array([True, False]), reach=10.0)
    assert knowledge.encounters.sum() == 40
    assert knowledge.collisions.sum() == 20
    assert knowledge.rows()[0]["collisions"] == 20
    p = knowledge.probability()
    assert p[met.speed_bin[0], met.direction[0], met.behaviour[0]] > 0.8
    assert p[met.speed_bin[1], met.direction[1], met.behaviour[1]] < 0.2
    again = Knowledge.from_json(knowledge.to_json())
    np.testing.assert_array_equal(again.probability(), p)


def test_without_encounters_every_cell_is_equally_unknown():
    p = Knowledge.none(strength=4.0).probability()
    assert p.shape == SHAPE
    assert np.ptp(p) < 1e-12


def test_wilson_interval_of_one_in_ten_is_the_textbook_one():
    low, high = wilson(1, 10)
    assert low == pytest.approx(0.0179, abs=1e-3)
    assert high == pytest.approx(0.4042, abs=1e-3)


def test_risk_ignores_what_comes_too_early_to_react():
    target = drive((0, 0), 0.0, 10.0)
    soon, late = drive((10, -10), np.pi / 2, 10.0), drive((50, -50), np.pi / 2, 10.0)
    met = encounters(target, CAR, together(soon, late), np.stack([CAR] * 2))
    knowledge = Knowledge.none(4.0).with_outcomes(met, np.array([True, True]), reach=10.0)
    risks = risk(met, knowledge, PRESSURE)
    assert risks[0] < 0.2 * risks[1]


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.floats(1e-4, 1.0), min_size=1, max_size=32),
    st.lists(st.floats(1e-3, 1.0), min_size=32, max_size=32),
    st.floats(0.0, 5.0),
)
def test_leaning_keeps_a_distribution_within_the_ratio_bound(weights, risks, strength):
    natural = np.array(weights) / np.sum(weights)
    pressure = PressureSettings(strength=strength, reach=10.0, max_ratio=8.0, reaction_time=1.5)
    used = lean(natural, np.array(risks[: len(natural)]), pressure)
    assert used.sum() == pytest.approx(1.0, abs=1e-5)
    assert np.all(used <= 8.0 * natural * 1.001)
    assert np.all(used >= natural / 8.0 * 0.999)
    if strength == 0:
        np.testing.assert_allclose(used, natural, rtol=1e-4)


def test_a_rounds_intervals_are_over_recordings():
    metrics = {name: np.array([1.0, 1.0, 4.0]) for name in ("collision", "absolute_acceleration", "acceleration")}
    motion = together(drive((0, 0), 0, 5), drive((0, 0), 0.5, 5), drive((0, 0), 1, 9))
    for recordings, ends in ((["a", "a", "b"], (1.0, 4.0)), (["a"] * 3, (np.nan, np.nan))):
        scenarios = [f"{recording}-{number:03}" for number, recording in enumerate(recordings)]
        summary = RoundSummary(metrics, {"collision": np.array([0.0, 1.0, 1.0])}, scenarios, motion, np.arange(3))
        joined = RoundSummary.joined([summary])
        found = joined.numbers(200, np.random.default_rng(0))
        assert (found["collision"], found["recordings"]) == (2.0, len(set(recordings)))
        assert (found["collision.low"], found["collision.high"]) == pytest.approx(ends, nan_ok=True)
        assert joined.per_run()[0] == scenarios
