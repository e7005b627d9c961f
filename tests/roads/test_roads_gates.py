"""Gates: who is judged by which signal where several ways begin at one line."""

import numpy as np
import pytest

from drivegen.checker.scene import check_samples
from drivegen.core.roadmap import LaneControl
from drivegen.core.samples import Violation
from drivegen.core.signals import Signals, SignalState
from drivegen.roads.gates import Gates
from tests.checking import LIMITS
from tests.scenes import drive, joined, road_map, scenario, stack

STEPS = 101


def fan(*degrees):
    """A road of 50 m to one line, and ways of 60 m behind it."""
    ends = [(60 * np.cos(angle), 60 * np.sin(angle)) for angle in np.deg2rad(degrees)]
    ways = range(1, 1 + len(degrees))
    lines = [[(-50, 0), (0, 0)], *([(0, 0), end] for end in ends)]
    return road_map(lines, [(0, way) for way in ways], ways, [(way, LaneControl.SIGNAL) for way in ways])


@pytest.mark.parametrize("red", [1, 2, 3])
def test_each_way_of_a_fan_is_judged_by_its_own_light(red):
    """The outer two are not near each other in direction, only both near the one between."""
    roads = fan(0, 25, 50)
    states = np.full((3, STEPS), SignalState.GREEN, np.uint8)
    states[red - 1] = SignalState.RED
    signals = Signals(np.arange(1, 4, dtype=np.int32), states)
    for way in (1, 2, 3):
        log = stack([drive(joined(roads, 0, way), 20, 8, STEPS)])
        violation, _ = check_samples(scenario(roads, log, signals=signals), log[np.newaxis], LIMITS)
        assert bool(violation[0, 0] & Violation.RED_LIGHT) == (way == red), way


@pytest.mark.parametrize("degrees", [(0, 25, 50), (50, 0, 25), (0, 20, 40, 60, 80), (0, 90, 180)])
def test_the_first_gate_of_every_group_is_in_it(degrees):
    roads = fan(*degrees)
    ways = np.arange(1, 1 + len(degrees), dtype=np.int32)
    group = Gates.of(roads, Signals(ways, np.zeros((len(ways), 2), np.uint8))).group
    assert (group[group] == group).all()
    assert len(set(group.tolist())) == (3 if 180 in degrees else 1)
