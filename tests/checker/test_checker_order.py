"""Giving way among ways that all wait."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.checker.scene import check_samples
from drivegen.core.roadmap import LaneControl
from drivegen.core.samples import Violation
from tests.checking import LIMITS
from tests.scenes import crossing, drive, joined, scenario, stack


@pytest.mark.parametrize(("order", "illegal"), [([], []), ([(8, 11)], [0]), ([(11, 8)], [])])
def test_one_is_judged_who_cuts_in_where_the_map_says_that_he_waits(order, illegal):
    """From the west, and a little later from the south."""
    roads = replace(crossing(control=LaneControl.YIELD), yields_to=np.array(order, np.int32).reshape(-1, 2))
    motion = stack([drive(joined(roads, 0, 8, 4), 66, 6, 101), drive(joined(roads, 1, 11, 5), 36, 10, 101)])
    flags, _ = check_samples(scenario(roads, motion), motion[np.newaxis], LIMITS)
    assert np.flatnonzero(flags[0] & Violation.STOP_OR_YIELD).tolist() == illegal
