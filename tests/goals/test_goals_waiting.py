"""What traffic waits for: signals by when they open and close, queues by where their head stands and what lies beyond."""

import numpy as np
import pytest

from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import Signals, SignalState
from drivegen.goals.traffic import Neighbours, Queue, look_ahead
from drivegen.goals.waiting import IN_SIGHT, NEVER, NOBODY, Waiting
from drivegen.roads.graph import LaneGraph
from drivegen.roads.routes import feasible_routes
from tests import scenes

LENGTH = 4.6
RED, GREEN = SignalState.RED, SignalState.GREEN
SIGNALS = scenes.crossing()
YIELDING = scenes.crossing(control=LaneControl.YIELD)


def found(*cars, states=None, roads=SIGNALS, lanes=(0, 8, 4)):
    """What the first of several cars, each given by its start [m] and speed [m/s] on the way straight on, waits for there."""
    line = scenes.joined(roads, *lanes)
    log = scenes.stack([scenes.drive(line, start, speed, 101) for start, speed in cars])
    signals = None if states is None else Signals(np.array([8], np.int32), np.asarray(states, np.uint8)[None])
    scene = scenes.scenario(roads, log, signals=signals)
    v = scene.vehicles
    routes = feasible_routes(LaneGraph.of(roads), v.position[0], float(v.heading[0]), cars[0][1], 150.0)
    route = next(route for route in routes if set(lanes) <= set(route.lanes))
    around = Neighbours.of(scene, 0)
    ahead = look_ahead(scene, route, around, LENGTH)
    return Waiting.on(route, cars[0][1], LENGTH, ahead, Queue.on(route, around), scene.signals)


def test_a_signal_is_told_by_when_it_opens_and_closes():
    steps = np.arange(101)
    later = found((30, 5.0), states=np.where(steps < 60, RED, GREEN))
    assert (later.opens, later.closes, later.signal) == (pytest.approx(6.0), 0.0, True)
    assert later.open_share == pytest.approx(41 / 101)
    ending = found((30, 5.0), states=np.where(steps < 40, GREEN, SignalState.YELLOW))
    assert (ending.opens, ending.closes) == (0.0, pytest.approx(4.0))
    assert found((30, 5.0), states=np.full(101, RED)).opens == NEVER
    assert found((30, 5.0), states=np.full(101, GREEN)).closes == NEVER
    assert later.line == pytest.approx(50.0, abs=1.1)  # the arms are 80 m long


def test_a_signal_that_nobody_saw_is_none_and_the_line_is_where_one_may_have_to_wait():
    for unseen in (found((30, 5.0), states=np.zeros(101)), found((30, 5.0), roads=YIELDING)):
        assert (unseen.signal, unseen.opens, unseen.closes, unseen.open_share) == (False, 0.0, NEVER, 1.0)
        assert unseen.line == pytest.approx(50.0, abs=1.1)
        assert not unseen.explained


def test_a_queue_is_explained_only_by_a_closed_signal_that_its_head_stands_at():
    shut, still = np.full(101, RED), (20, 0.0)
    at_line = found(still, (60, 0.0), (70, 0.0), (76, 0.0), states=shut)
    assert (at_line.queued, at_line.explained) == (3, True)
    assert at_line.head_gap == pytest.approx(80 - 76 - LENGTH / 2, abs=1.1)
    assert found((76, 0.0), states=shut).explained, "the vehicle itself is the head"
    assert not found(still, (50, 0.0), states=shut).explained, "the head stands far from the line"
    assert not found(still, (76, 3.0), states=shut).explained, "the head drives"
    assert not found(still, (76, 0.0), states=np.full(101, GREEN)).explained


def test_who_stands_beyond_the_line_is_no_part_of_the_queue():
    blocked = found((60, 0.0), (95, 0.0), states=np.full(101, GREEN))
    assert (blocked.queued, blocked.beyond_speed) == (0, 0.0)
    assert blocked.beyond_gap == pytest.approx(15.0, abs=1.1)
    alone = found((60, 0.0), states=np.full(101, GREEN))
    assert (alone.beyond_gap, alone.beyond_speed) == (IN_SIGHT, NOBODY)
    assert (alone.head_gap, alone.head_speed) == (pytest.approx(20 - LENGTH / 2, abs=1.1), 0.0)


def test_on_an_open_road_there_is_no_line():
    roads = scenes.straight_road(300, 1)
    free = found((10, 10.0), (40, 8.0), (90, 7.0), roads=roads, lanes=(0,))
    assert free.line == np.inf
    assert free.head_gap == IN_SIGHT
    assert (free.queued, free.head_speed) == (1, pytest.approx(8.0))
    assert (free.beyond_gap, free.beyond_speed) == (pytest.approx(20.0, abs=1.1), pytest.approx(7.0))
