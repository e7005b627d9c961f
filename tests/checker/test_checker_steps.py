"""What happens within one step is judged: jumps, kicks, turning on the spot, driving backwards."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.samples import Violation
from tests.checker.test_checker_scene import LINE, ROAD, STEPS, judge, reversed_line, severity
from tests.checking import LIMITS
from tests.scenes import drive


def test_a_jump_within_one_step_is_illegal_though_its_window_hides_it():
    motion = drive(LINE, 10, 10, STEPS)
    motion.position[40:, 0] += 0.8  # 0.8 m/s over a window, LIMITS allow 1
    assert judge(ROAD, motion) == ([Violation.ACCELERATION], [40])
    for step in (1, STEPS - 1):
        motion = drive(LINE, 10, 10, STEPS)
        motion.position[step:, 0] += 0.8
        assert judge(ROAD, motion) == ([Violation.ACCELERATION], [step])


@pytest.mark.parametrize("step", [1, 40, STEPS - 1])
def test_a_kick_within_one_step_is_illegal_at_either_end_too(step):
    motion = drive(LINE, 10, 10, STEPS)
    motion.velocity[step:, 0] += 1.5  # positions follow: no window's acceleration is beyond 4 m/s2 and nothing jumps
    motion.position[step:, 0] += np.arange(STEPS - step, dtype=np.float32) * 0.15 + 0.075
    assert judge(ROAD, motion) == ([Violation.ACCELERATION], [step])
    assert severity(ROAD, "velocity_step", motion) == pytest.approx(1.5, abs=1e-3)
    assert severity(ROAD, "jump", motion) < 0.1


def test_a_track_of_single_frames_has_no_step_to_judge():
    motion = drive(LINE, 10, 10, STEPS)
    motion.valid[1::2] = False
    assert severity(ROAD, "velocity_step", motion) == -np.inf


def test_turning_on_the_spot_is_illegal():
    for speed in (0, 4):
        motion = drive(LINE, 10, speed, STEPS)
        motion.heading[30:60:2] += 0.4  # shakes its head
        assert judge(ROAD, motion) == ([Violation.CURVATURE], [30])
    bend = drive(LINE, 10, 10, STEPS)
    bend.heading[30:] += 0.25  # no more than a car turns on 1 m
    assert severity(ROAD, "spin", bend) < 0


def test_driving_backwards_is_the_wrong_way_and_slips():
    motion = drive(reversed_line(LINE), 10, 1.5, STEPS)
    motion.heading[:] = 0.0  # faces along the lane, moves against it
    assert judge(ROAD, motion, limits=replace(LIMITS, side_slip=2.0))[0] == [Violation.WRONG_WAY]
    assert severity(ROAD, "side_slip", motion) == pytest.approx(1.5, abs=1e-3)
    motion = drive(LINE, 10, 5, STEPS)
    motion.heading[:40] = np.pi  # moves along the lane, faces against it
    assert Violation.CURVATURE in judge(ROAD, motion)[0][0]
    assert severity(ROAD, "side_slip", motion) == pytest.approx(5, abs=1e-3)
