"""Lines with fewer points: none is farther from the drawn line than said, and none is drawn for nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegen.core.geometry import project
from drivegen.recording.lines import closed, flat, thinned


def test_a_straight_line_is_its_ends_and_a_corner_stays():
    line = np.array([[0.0, 0], [1, 0], [2, 0.05], [5, 0], [5, 3], [5, 9]])
    assert thinned(line, 0.1).tolist() == [[0, 0], [5, 0], [5, 9]]
    assert thinned(line, 0.01).tolist() == [[0, 0], [1, 0], [2, 0.05], [5, 0], [5, 9]]


def test_a_ring_and_a_line_on_the_spot_are_lines_still():
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    ring = closed(20 * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    kept = thinned(ring)
    assert 20 < len(kept) < 60
    assert np.array_equal(kept[0], kept[-1])
    assert len(thinned(np.zeros((5, 2)))) == 2


@given(st.integers(0, 2**31), st.sampled_from([0.02, 0.1, 1.0]))
def test_every_point_left_out_is_near_the_line_that_is_drawn(seed, tolerance):
    turns = np.cumsum(np.random.default_rng(seed).normal(0, 0.2, 60))
    line = np.cumsum(np.stack([np.cos(turns), np.sin(turns)], axis=1), axis=0)
    kept = thinned(line, tolerance)
    assert max(abs(project(kept, point)[1]) for point in line) <= tolerance + 1e-9
    assert len(thinned(kept, tolerance)) <= len(kept) <= len(line)


def test_heights_are_added():
    assert flat(np.array([[1.0, 2.0]]), 0.5).tolist() == [[1.0, 2.0, pytest.approx(0.5)]]
