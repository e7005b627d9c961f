"""Kendall's tau against scipy's, by hand, and where the answer is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kendalltau

from drivegen.metrics.ranking import Rates, agreements, ceiling, interval, kendall


@given(st.integers(2, 9), st.integers(0, 99))
@settings(max_examples=60)
def test_tau_is_scipys_with_drivers_repeated(count, seed):
    random = np.random.default_rng(seed)
    first, second = random.integers(0, 4, (2, count)).astype(float)  # with ties
    times = random.integers(0, 4, count)
    wanted = kendalltau(np.repeat(first, times), np.repeat(second, times)).statistic if times.sum() > 1 else np.nan
    assert kendall(first[None], second[None], times[None].astype(float))[0] == pytest.approx(wanted, nan_ok=True)


def test_by_hand():
    first, second = np.array([[1.0, 2, 3, 4]]), np.array([[1.0, 2, 4, 3]])
    assert kendall(first, second, np.ones((1, 4)))[0] == pytest.approx((5 - 1) / 6)
    assert np.isnan(kendall(first, np.zeros((1, 4)), np.ones((1, 4)))[0])


def traffic(skill, scenes, seed):
    """Drivers that fail with the probabilities `skill`, in scenes of which four share a recording."""
    random = np.random.default_rng(seed)
    return Rates((random.random((len(skill), scenes)) < skill[:, None]).astype(float), [f"r{i // 4}" for i in range(scenes)])


def test_the_same_traffic_agrees_with_itself_and_traffic_that_says_nothing_does_not():
    skill = np.linspace(0.02, 0.6, 20)
    real, alike = traffic(skill, 400, 1), traffic(skill, 400, 2)
    blank = traffic(np.full(20, 0.3), 400, 3)
    same, as_good, nothing = agreements(real, [real, alike, blank], 200, np.random.default_rng(7))
    assert same[0] == 1
    assert interval(as_good).low > 0.7
    assert interval(nothing).low < 0 < interval(nothing).high
    assert interval(as_good - nothing).low > 0


def test_the_ceiling_is_what_halves_agree_by():
    skill = np.linspace(0.02, 0.6, 20)
    few, many = (interval(ceiling(traffic(skill, scenes, 1), 200, np.random.default_rng(7))) for scenes in (40, 1000))
    assert few.value < many.value
    assert many.value > 0.85
    assert np.isnan(ceiling(traffic(skill, 4, 1), 200, np.random.default_rng(7))[0])  # one recording


def test_a_scene_in_which_nobody_fails_changes_no_order():
    real = traffic(np.linspace(0.1, 0.6, 8), 40, 1)
    longer = Rates(np.concatenate([real.values, np.zeros((8, 40))], axis=1), [*real.recordings, *(f"s{i}" for i in range(40))])
    assert agreements(real, [longer], 5, np.random.default_rng(7))[0, 0] == 1


def test_traffic_of_the_same_recordings_is_compared_draw_by_draw():
    skill = np.linspace(0.02, 0.6, 20)
    real, kind = traffic(skill, 400, 1), traffic(skill, 200, 2)
    alike, same, shorter = agreements(
        real, [kind, kind, Rates(kind.values[:, ::2], kind.recordings[::2])], 50, np.random.default_rng(7)
    )
    assert np.array_equal(alike, same)
    own = agreements(real, [real], 50, np.random.default_rng(7))[0]
    np.testing.assert_allclose(own, 1.0)
    assert np.std(alike - shorter) < np.std(alike - np.roll(shorter, 1))
