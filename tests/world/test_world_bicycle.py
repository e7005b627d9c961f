"""The kinematic bicycle against closed forms, and its limits."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.world.bicycle import GRIP, SHARPEST, STEERING_RATE, WHEELBASE
from drivegen.world.ego import HARDEST_BRAKING
from drivegen.world.observation import Action
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.scenes import crossing, drive, joined, scenario, stack, straight_road

ROAD = straight_road(600)
LINE = ROAD.centreline[0].astype(np.float64)
LENGTH = 4.6


def world(speed=8.0, steps=301):
    log = stack([drive(LINE, 200, speed, steps), drive(LINE, 590, 0, steps)])
    scenes = Scenes.of([scenario(ROAD, log)], [log])
    return World(scenes, 1, free=True)


def go(world, acceleration, steering, steps):
    action = Action(torch.tensor([float(acceleration)]), steering=torch.tensor([float(steering)]))
    for _ in range(steps):
        world.advance(action)
    return world.ego


def test_with_the_wheels_held_it_drives_a_circle_of_the_radius_that_the_model_says():
    free, angle = world(5.0), 0.2
    go(free, 0, angle, 10)
    slip = np.arctan(0.5 * np.tan(angle))
    radius = WHEELBASE * LENGTH / (np.cos(slip) * np.tan(angle))
    seen = []
    for _ in range(200):
        go(free, 0, angle, 1)
        seen.append(free.ego.position[0].numpy().copy())
    low, high = np.min(seen, axis=0), np.max(seen, axis=0)
    assert (high - low) / 2 == pytest.approx([radius, radius], rel=0.03)
    assert float(free.ego.speed) == 5.0


def test_straight_on_it_is_where_a_target_on_its_path_is():
    free = world()
    ego = go(free, 1.0, 0.0, 20)
    assert float(ego.along) == pytest.approx(8 * 2 + 0.5 * 1.0 * 2 * 2.1, abs=0.01)
    assert (float(ego.offset), float(ego.course)) == pytest.approx((0, 0), abs=1e-3)
    assert float(go(free, -99, 0, 1).speed) == pytest.approx(10 - HARDEST_BRAKING * 0.1)
    assert float(go(free, -99, 0, 30).speed) == 0


def test_wheels_turn_by_no_more_than_0_8_rad_a_second():
    free = world(2.0)
    angles = [float(go(free, 0, 1.0, 1).wheel) for _ in range(9)]
    assert angles == pytest.approx([0.08, 0.16, 0.24, 0.32, 0.4, 0.48, 0.56, 0.6, 0.6])


@settings(max_examples=30, deadline=None)
@given(st.floats(0.5, 25), st.floats(-2, 2), st.lists(st.floats(-1, 1), min_size=5, max_size=20))
def test_limits_hold_whatever_is_asked(speed, acceleration, angles):
    free = world(speed)
    for angle in angles:
        before = free.ego
        after = go(free, acceleration, angle, 1)
        turned = abs(float(after.heading - before.heading))
        assert abs(float(after.wheel)) <= SHARPEST + 1e-5
        eased = float(after.speed) > float(before.speed)  # a faster car has to straighten its wheels at once
        assert abs(float(after.wheel - before.wheel)) <= STEERING_RATE * 0.1 + 1e-5 or eased
        assert turned * float(after.speed) / 0.1 <= GRIP + 1e-3


def test_what_it_sees_of_others_and_of_itself_is_in_the_frame_of_its_path():
    free = world()
    go(free, 0, 0.1, 15)
    seen = free.observe()
    x, y = free.ego.position[0].tolist()
    assert float(seen.along) == pytest.approx(x - 200, abs=0.02)
    assert float(seen.offset) == pytest.approx(y, abs=0.02)
    assert float(seen.course) == pytest.approx(float(free.ego.heading), abs=1e-5)
    assert float(seen.ahead[0, 0]) == pytest.approx(590 - x, abs=0.05)


def test_in_a_bend_it_gets_no_farther_along_its_path_than_the_bend_allows():
    roads = crossing()
    log = stack([drive(joined(roads, 0, 9, 5), 60, 6, 101), drive(LINE, 290, 0, 101)])
    free = World(Scenes.of([scenario(roads, log)], [log]), 1, free=True)
    random = np.random.default_rng(0)
    for _ in range(100):
        before = free.ego
        go(free, random.uniform(-2, 2), random.uniform(-1, 1), 1)
        distance = (free.ego.position - before.position).norm()
        assert abs(float(free.ego.along - before.along)) <= 4 * float(distance) + 1.0
        near = free.paths.position(torch.arange(0, 200, 0.25)[None])[0] - free.ego.position
        window = (torch.arange(0, 200, 0.25) - before.along).abs() < 8
        assert float(free.ego.offset.abs()) <= float(near.norm(dim=-1)[window].min()) + 0.3
