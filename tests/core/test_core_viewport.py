"""Where pictures and recordings look."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.viewport import window
from tests.scenes import busy_crossing


def test_all_that_fits_lies_in_the_middle():
    log = busy_crossing().log
    centre, width = window(log, 60.0, 1000.0)
    points = log.position[log.valid]
    assert centre == pytest.approx((points.min(axis=0) + points.max(axis=0)) / 2)
    assert width == pytest.approx(np.ptp(points, axis=0).max() + 20)
    assert window(log, 5000.0, 6000.0)[1] == 5000


def test_a_scene_too_wide_is_shown_where_most_of_it_happens_with_the_target_s_beginning():
    """A target that drives 400 m away from seven that stand: they stay in the picture, and so does where it began."""
    log = busy_crossing().log
    position = np.repeat(log.position[:, :1], log.steps, axis=1)
    position[0, :, 0] = position[0, 0, 0] + np.linspace(0, 400, log.steps)
    centre, width = window(replace(log, position=position, valid=np.ones_like(log.valid)), 60.0, 200.0)
    assert width == 200
    assert np.abs(position[:, 0] - centre).max() <= 100


def test_the_target_s_beginning_is_there_wherever_most_others_are():
    """Seven others stand 300 m away: too far to be shown with it."""
    log = busy_crossing().log
    position = np.repeat(log.position[:, :1], log.steps, axis=1)
    position[1:, :, 0] += 300.0
    centre, width = window(replace(log, position=position, valid=np.ones_like(log.valid)), 60.0, 200.0)
    assert np.abs(position[0, 0] - centre).max() <= width / 2


def test_a_target_that_is_never_there_leaves_the_window_to_the_others_and_nobody_at_all_is_refused():
    log = busy_crossing().log
    log.valid[0] = False
    assert window(log, 60.0, 1000.0)[0] == pytest.approx(window(log[1:], 60.0, 1000.0)[0])
    with pytest.raises(UnusableInput, match="nothing to be looked at"):
        window(replace(log, valid=np.zeros_like(log.valid)), 60.0, 200.0)
