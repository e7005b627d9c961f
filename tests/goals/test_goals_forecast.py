"""Where usual drivers end: on an empty road, behind others, at signals."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.signals import Signals, SignalState
from drivegen.goals.forecast import Habit, forecast
from drivegen.goals.traffic import Neighbours, Queue, look_ahead
from drivegen.roads.graph import LaneGraph
from drivegen.roads.routes import feasible_routes
from tests import scenes

LENGTH = 4.6
ROADS = scenes.straight_road(600, 1)
ALONG = scenes.joined(ROADS, 0)


def on_road(own, *others, signals=None, roads=ROADS, line=ALONG):
    """Forecast of the first of several cars, each given by its start [m] and speed [m/s] on one line."""
    log = scenes.stack([scenes.drive(line, start, speed, 101) for start, speed in (own, *others)])
    scene = scenes.scenario(roads, log, signals=signals)
    v = scene.vehicles
    route = feasible_routes(LaneGraph.of(roads), v.position[0], float(v.heading[0]), own[1], 260.0)[0]
    around = Neighbours.of(scene, 0)
    ahead = look_ahead(scene, route, around, LENGTH)
    return forecast(route, own[1], LENGTH, ahead, Queue.on(route, around), scene.signals, 100)


def test_a_car_alone_reaches_the_limit_and_no_more():
    end = on_road((10, 0.0))
    assert end.s[Habit.USUAL] == pytest.approx(end.s[Habit.ALONE])
    assert 0.75 * scenes.LIMIT < end.speed[Habit.USUAL] <= scenes.LIMIT
    assert end.s[Habit.CALM] < end.s[Habit.USUAL]
    assert on_road((10, scenes.LIMIT)).s[Habit.KEEPING] == pytest.approx(10 * scenes.LIMIT, rel=0.01)


def test_a_car_stops_behind_one_that_stands_in_a_jam():
    end = on_road((10, 10.0), (60, 0.0))
    assert end.s[Habit.JAM] < 50 - LENGTH
    assert end.speed[Habit.JAM] < 1.5
    assert end.s[Habit.ALONE] > 100


def test_a_closed_signal_holds_and_an_open_one_does_not():
    roads = scenes.crossing()
    line = scenes.joined(roads, 0, 8, 4)
    states = {
        name: np.full((1, 101), state, np.uint8) for name, state in (("red", SignalState.RED), ("green", SignalState.GREEN))
    }
    states["later"] = np.where(np.arange(101) < 60, SignalState.RED, SignalState.GREEN).astype(np.uint8)[None]
    end = {
        name: on_road((30, 10.0), signals=Signals(np.array([8], np.int32), state), roads=roads, line=line).s[Habit.USUAL]
        for name, state in states.items()
    }
    assert end["red"] + LENGTH / 2 < 50.5 < end["later"] < end["green"]  # the line is 50 m ahead, lines have a point a metre


@settings(max_examples=40, deadline=None)
@given(st.floats(0, 20), st.floats(0, 20), st.floats(8, 80))
def test_nobody_drives_through_the_one_ahead_and_habits_are_in_order(speed, leader, gap):
    end = on_road((10, speed), (10 + gap, leader))
    head = on_road((10 + gap, leader))
    assert np.isfinite(end.s).all()
    assert (end.s >= 0).all()
    assert end.s[Habit.JAM] <= end.s[Habit.ALONE] + 1e-6
    assert end.s[Habit.USUAL] <= end.s[Habit.ALONE] + 1e-6
    closing = max(speed - leader, 0.0) ** 2 / 8
    if closing < gap - LENGTH - 2:
        assert end.s[Habit.USUAL] <= gap + head.s[Habit.USUAL] - LENGTH + 0.5


def test_in_steady_following_the_jam_habit_ends_behind_the_keeping_one():
    end = on_road((10, 10.0), (40, 10.0))
    assert end.s[Habit.JAM] <= end.s[Habit.KEEPING]


def test_the_queue_is_sorted_and_of_this_lane_only():
    roads = scenes.straight_road(300, 2)
    log = scenes.stack(
        [scenes.drive(scenes.joined(roads, lane), start, 5.0, 101) for lane, start in ((0, 10), (0, 90), (1, 30), (0, 50))]
    )
    scene = scenes.scenario(roads, log)
    route = feasible_routes(LaneGraph.of(roads), scene.vehicles.position[0], 0.0, 5.0, 200.0)[0]
    queue = Queue.on(route, Neighbours.of(scene, 0))
    assert queue.s == pytest.approx([40, 80], abs=0.1)
    assert len(Queue.on(route, Neighbours.of(replace(scene, vehicles=scene.vehicles[:1]), 0)).s) == 0
