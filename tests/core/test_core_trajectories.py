"""Tracks, whatever they are of."""

import numpy as np
import pytest

from tests.scenes import busy_crossing


@pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
def test_what_is_padded_is_as_before_and_then_not_valid(shape):
    log = busy_crossing(51, "crossing").log
    track = {(): log[0], (2,): log[:2], (1, 2): log[np.newaxis, :2]}[shape]
    longer = track.padded(60)
    assert longer.valid.shape == (*shape, 60)
    assert not longer.valid[..., 51:].any()
    for name in ("position", "heading", "velocity", "valid"):
        np.testing.assert_array_equal(getattr(longer.until(51), name), getattr(track, name))
    np.testing.assert_array_equal(track.padded(51).position, track.position)


def test_a_track_with_gaps_has_a_stretch_for_each_time_that_it_was_seen():
    track = busy_crossing(20).log[0]
    track.valid[[0, 5, 6, 12]] = False
    for line, (first, last) in zip(track.stretches(), ((1, 5), (7, 12), (13, 20)), strict=True):
        np.testing.assert_array_equal(line, track.position[first:last])
    track.valid[:] = False
    assert track.stretches() == []
