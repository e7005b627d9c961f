from dataclasses import replace

import numpy as np
import pytest
import torch

from drivegen.drivers import idm
from drivegen.simulators.batch import Plugin
from drivegen.world.observation import Observation, Paths
from drivegen.world.paths import packed
from tests.checking import IDM
from tests.scenes import LIMIT, drive, scenario, stack, straight_road

ROAD = straight_road(900)
LINE = ROAD.centreline[0].astype(np.float64)


def seen(speed, gap=None, leader_speed=0.0, left=0.0, across=0.0, limit=20.0):
    """One target of 4 m x 2 m and one other of the same size, `gap` metres ahead bumper to bumper."""
    one = torch.ones(1)
    other = torch.ones(1, 1)
    line = torch.stack([torch.arange(10.0), torch.zeros(10)], -1)[None]
    paths = Paths(line, torch.zeros(1, 10), torch.full((1, 10), limit), torch.tensor([9.0]))
    return Observation(
        0 * one.long(), 0 * one, 0 * one, 0 * one, speed * one, 4 * one, 2 * one, limit * one, (4 + (gap or 0)) * other,
        left * other, 2 * other, other, leader_speed * other, across * other, torch.tensor([[gap is not None]]), paths,
    )  # fmt: skip


def acceleration(settings=IDM, **scene):
    return float(idm.Plugin(settings).act(seen(**scene)).acceleration)


def test_on_a_free_road_acceleration_falls_from_a_max_to_zero_at_the_limit():
    assert acceleration(speed=0.0) == pytest.approx(1.5)
    assert acceleration(speed=10.0) == pytest.approx(1.5 * (1 - 0.5**4))
    assert acceleration(speed=20.0) == pytest.approx(0.0, abs=1e-6)
    assert acceleration(speed=13.9, limit=float("nan")) == pytest.approx(0.0, abs=1e-6)


def test_the_formula_with_a_leader():
    wanted = 2.0 + 10 * 1.5 + 10 * (10 - 6) / (2 * np.sqrt(1.5 * 2.0))
    assert acceleration(speed=10.0, gap=30.0, leader_speed=6.0) == pytest.approx(
        1.5 * (1 - 0.5**4 - (wanted / 30) ** 2), rel=1e-5
    )


def test_at_the_equilibrium_gap_nothing_changes():
    speed = 8.0
    gap = (2.0 + speed * 1.5) / np.sqrt(1 - (speed / 20) ** 4)
    assert acceleration(speed=speed, gap=float(gap), leader_speed=speed) == pytest.approx(0.0, abs=1e-5)


def test_braking_is_bounded_by_what_tyres_can_do():
    assert acceleration(speed=15.0, gap=0.5) == -9.0


def test_only_boxes_in_the_way_count():
    free = acceleration(speed=10.0)
    assert acceleration(speed=10.0, gap=10.0, left=2.1) == pytest.approx(free)
    assert acceleration(speed=10.0, gap=10.0, left=1.9) < 0
    assert acceleration(replace(IDM, side_margin=0.3), speed=10.0, gap=10.0, left=2.1) < 0
    assert acceleration(speed=10.0, gap=-9.0) == pytest.approx(free)  # behind


def test_crossing_vehicles_count_once_they_will_be_in_the_way():
    crossing = {"speed": 10.0, "gap": 15.0, "left": -12.0, "across": 5.0}
    free = acceleration(speed=10.0)
    assert acceleration(**crossing) == pytest.approx(free)
    assert acceleration(replace(IDM, look_ahead=1.0), **crossing) == pytest.approx(free)
    assert acceleration(replace(IDM, look_ahead=2.1), **crossing) < 0
    assert acceleration(replace(IDM, look_ahead=2.1), **(crossing | {"across": -5.0})) == pytest.approx(free)
    assert acceleration(replace(IDM, look_ahead=9.0), **crossing) < 0  # it will have crossed by then


def test_a_run_from_rest_follows_the_differential_equation():
    motion = stack([drive(LINE, 10, 0.01, 101)])
    outcome = Plugin().run(idm.Plugin(IDM), [scenario(ROAD, motion)], [motion])
    speed, fine = 0.01, 0.001
    speeds = []
    for step in range(10001):
        if step % 100 == 0:
            speeds.append(speed)
        speed += fine * 1.5 * (1 - (speed / LIMIT) ** 4)
    assert outcome.motion.speed[0] == pytest.approx(np.array(speeds), abs=0.1)
    assert outcome.motion.position[0, -1, 0] - 10 == pytest.approx(np.sum(speeds[1:]) * 0.1, abs=0.5)


def test_behind_a_stopped_car_it_stops_at_the_minimal_gap():
    motion = stack([drive(LINE, 10, 10, 401), drive(LINE, 90, 0, 401)])
    outcome = Plugin().run(idm.Plugin(IDM), [scenario(ROAD, motion)], [motion])
    gap = 90 - 4.6 - outcome.motion.position[0, -1, 0]
    assert not outcome.collided[0]
    assert gap == pytest.approx(2.0, abs=0.3)
    assert outcome.motion.speed[0, -1] < 0.1


def test_it_slows_down_before_a_lower_limit_and_not_after():
    """From 13.9 to 6 m/s at x = 100: as SUMO does, it arrives there slowly enough, without braking hard."""
    limits = np.where(np.arange(300) < 90, 13.9, 6.0)  # the path begins at x = 10
    paths = packed([LINE[1:31]], [np.interp(np.arange(30) * 10, np.arange(300), limits)])
    motion = stack([drive(LINE, 10, 13, 151)])
    outcome = Plugin().run(idm.Plugin(IDM), [scenario(ROAD, motion)], [motion], paths)
    speed, x = outcome.motion.speed[0], outcome.motion.position[0, :, 0]
    assert speed[x + 2.3 > 100].max() < 7.5
    assert np.diff(speed).min() / 0.1 > -4.0
    assert speed[-1] == pytest.approx(6.0, abs=0.4)
