"""Encounters, knowledge and pressure by hand cases and properties."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.corner_cases.encounters import Behaviour, Direction, encounters
from drivegen.corner_cases.knowledge import SHAPE, Knowledge, wilson
from drivegen.corner_cases.pressure import PressureSettings, lean, risk
from drivegen.scenario import DT, Trajectories

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
    return Trajectories(*(np.stack([getattr(m, name) for m in motions]) for name in ("position", "heading", "velocity", "valid")))


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
