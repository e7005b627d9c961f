"""Who is held by a line that it comes to from beyond its plane."""

import numpy as np

from drivegen.checker.scene import check_samples
from drivegen.core.samples import Violation
from drivegen.core.signals import Signals, SignalState
from tests.checking import LIMITS
from tests.scenes import crossing, drive, joined, scenario, stack

CROSS = crossing()
STRAIGHT = joined(CROSS, 0, 8, 4)
STEPS = 101


def round_the_bend():
    """A car on the other side of a hairpin: beyond the line, then ahead of it, then over it."""
    line = STRAIGHT[0] + [80.0, 0.0]
    angle = np.radians(np.arange(90, 271, 10))[:, None]
    bend = line + [-20.0, 6.0] + 6.0 * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    return drive(np.concatenate([line[None] + [10.0, 12.0], bend, STRAIGHT[STRAIGHT[:, 0] > line[0] - 19.0]]), 0, 8, STEPS)


def on_red(state):
    log = stack([round_the_bend()])
    lights = Signals(np.array([8], np.int32), np.full((1, STEPS), state, np.uint8))
    violation, _ = check_samples(scenario(CROSS, log, signals=lights), log[np.newaxis], LIMITS)
    return bool(violation[0, 0] & Violation.RED_LIGHT)


def test_who_comes_round_a_bend_from_beyond_the_line_is_held_by_its_light():
    assert on_red(SignalState.RED)
    assert not on_red(SignalState.GREEN)
