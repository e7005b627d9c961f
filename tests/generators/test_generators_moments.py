"""Moments to learn from are the same whether they are listed or found when asked for."""

import numpy as np
import pytest

from drivegen.generators.shared.closed_loop import Tracks
from drivegen.generators.shared.moments import Moments
from tests.models import two_lanes
from tests.scenes import any_scenario, busy_crossing

TRACKS = Tracks.of_logs([busy_crossing(41, "a"), any_scenario(3, "b"), two_lanes(9.0, "c", 31)])


def listed(throughout: bool) -> tuple[np.ndarray, np.ndarray]:
    """All boxes and steps, of vehicles seen at every fifth step and ten steps later."""
    ends = TRACKS.valid[:, :-10] & TRACKS.valid[:, 10:] & TRACKS.planned[:, None]
    between = np.lib.stride_tricks.sliding_window_view(TRACKS.valid, 11, axis=1).all(axis=-1)
    ends[:, np.arange(ends.shape[1]) % 5 != 0] = False
    return np.nonzero(ends & between if throughout else ends)


@pytest.mark.parametrize("throughout", [False, True])
def test_moments_are_vehicles_seen_at_both_ends_or_throughout(throughout: bool) -> None:
    moments, wanted = Moments(TRACKS, 5, 10, throughout=throughout), listed(throughout)
    assert len(moments) == len(wanted[0]) > 50
    np.testing.assert_array_equal(moments[np.arange(len(moments))], wanted)
    rows = np.array([40, 0, len(moments) - 1, 7, 7])
    np.testing.assert_array_equal(moments[rows], [column[rows] for column in wanted])


def test_of_too_many_some_are_taken_evenly() -> None:
    moments, wanted = Moments(TRACKS, 5, 10, most=7), listed(throughout=False)
    kept = np.linspace(0, len(wanted[0]) - 1, 7).astype(int)
    np.testing.assert_array_equal(moments[np.arange(7)], [column[kept] for column in wanted])
    assert len(moments) == 7


def test_of_chosen_boxes_those_are_found_and_of_short_logs_none() -> None:
    targets = TRACKS.start[:-1]
    scene, step = np.nonzero(TRACKS.valid[targets])
    moments = Moments(TRACKS, 1, 0, boxes=targets)
    np.testing.assert_array_equal(moments[np.arange(len(moments))], (targets[scene], step))
    assert len(Moments(TRACKS, 5, 200)) == 0
