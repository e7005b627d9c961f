"""Fronts by hand and by plain loops."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.metrics.front import on_front


def test_a_front_by_hand():
    error = np.array([2.0, 1.5, 3.0, 2.0, np.nan])
    diversity = np.array([1.0, 0.8, 1.1, 0.9, 1.0])
    assert on_front(error, diversity).tolist() == [True, True, False, False, False]


def test_equal_points_are_both_on_it():
    assert on_front(np.array([1.0, 1.0]), np.array([0.75, 1.25])).tolist() == [True, True]


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_it_is_that_of_loops(seed):
    random = np.random.default_rng(seed)
    error, far = random.integers(0, 5, 9).astype(float), random.integers(0, 5, 9) / 10

    def beaten(i):
        return any(error[j] <= error[i] and far[j] <= far[i] and (error[j] < error[i] or far[j] < far[i]) for j in range(9))

    assert on_front(error, 1 + far).tolist() == [not beaten(i) for i in range(9)]
