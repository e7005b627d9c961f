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
