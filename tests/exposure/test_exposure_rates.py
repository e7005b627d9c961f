"""Rates of failure from strata: intervals against textbook ones, and against laws whose rate is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from drivegen.core.seeds import rng
from drivegen.exposure.rates import EDGES, Trial, allocate, estimate, rate_of, verified

DRAWS = 20_000


def law(knows: float) -> tuple[np.ndarray, np.ndarray]:
    """Who fails in which of many draws, and how near others come: in a tenth of the two in a hundred in which they touch its way.

    And in one in 5000 of the others. Where nearness knows nothing (`knows` 0), they seem to touch it anywhere.
    """
    random = rng(7, "law")
    hard, guess = random.random(DRAWS) < 0.02, random.random(DRAWS) < 0.02
    failed = random.random(DRAWS) < np.where(hard, 0.3, 2e-4)
    touched = np.where(random.random(DRAWS) < knows, hard, guess)
    return failed, np.where(touched, 0.0, random.uniform(2.0, 20.0, DRAWS))


def test_one_stratum_has_garwoods_exact_interval():
    interval = rate_of(np.ones(1), np.array([3]), np.array([1000]))
    low, high = chi2.ppf(0.025, 6) / 2000, chi2.ppf(0.975, 8) / 2000
    np.testing.assert_allclose([interval.value, interval.low, interval.high], [0.003, low, high], rtol=1e-9)


def test_no_failure_leaves_what_few_runs_cannot_rule_out():
    interval = rate_of(np.array([0.9, 0.1]), np.array([0, 0]), np.array([90, 100]))
    assert (interval.value, interval.low) == (0.0, 0.0)
    assert interval.high == pytest.approx(0.01 * -np.log(0.025))  # the heaviest run weighs 0.9 / 90


@given(st.lists(st.tuples(st.integers(1, 50), st.integers(0, 5)), min_size=1, max_size=6))
def test_interval_is_that_of_fay_and_feuer(counts):
    runs, failed = (np.array(column) for column in zip(*counts, strict=True))
    share = np.full(len(runs), 1 / len(runs))
    interval = rate_of(share, failed, runs)
    value = sum(s * f / n for s, f, n in zip(share, failed, runs, strict=True))
    variance = sum(s**2 * f / n**2 for s, f, n in zip(share, failed, runs, strict=True))
    most = max(s / n for s, n in zip(share, runs, strict=True))
    more, wider = value + most, variance + most**2
    assert interval.value == pytest.approx(value)
    assert interval.low == pytest.approx(variance / (2 * value) * chi2.ppf(0.025, 2 * value**2 / variance) if value else 0.0)
    assert interval.high == pytest.approx(min(wider / (2 * more) * chi2.ppf(0.975, 2 * more**2 / wider), 1.0))


def test_more_runs_go_where_it_has_failed_and_some_where_little_is_known():
    share, made = np.array([0.01, 0.09, 0.9]), np.array([10, 90, 900])
    room = np.full(3, 10_000)
    more = allocate(share, np.array([5, 0, 0]), made, 1000, room)
    assert 990 <= more.sum() <= 1000
    assert more[0] > 10 * made[0]
    np.testing.assert_array_equal(allocate(share, np.array([0, 0, 0]), np.array([0, 0, 0]), 100, room), [1, 9, 90])
    np.testing.assert_array_equal(allocate(share, np.array([9, 0, 0]), made, 100, np.array([3, 0, 0])), [3, 0, 0])


def test_runs_for_which_a_stratum_has_no_draws_left_are_made_in_others():
    failed, near = law(1.0)
    few = rng(7, "few").permutation(DRAWS)[:2500]  # of which some fifty are as near as those that fail
    found = estimate(near[few], lambda picks: failed[few][picks], 2000, rng(7, "test"))
    assert 1990 < found.runs.sum() <= 2000


def test_who_always_fails_has_no_rate_above_1():
    interval = rate_of(np.ones(1), np.array([1000]), np.array([1000]))
    assert (interval.value, interval.high) == (1.0, 1.0)
    assert interval.low < 0.95


@given(st.lists(st.floats(0, 20), min_size=1, max_size=300), st.integers(1, 400), st.integers(0, 5))
def test_no_draw_is_run_twice_and_never_more_than_asked_for(near, runs, seed):
    seen: list[int] = []

    def run(picks: np.ndarray) -> np.ndarray:
        seen.extend(picks.tolist())
        return picks % 7 == 0

    found = estimate(np.array(near), run, runs, rng(seed, "test"))
    assert len(set(seen)) == len(seen) == found.runs.sum()
    assert len(seen) <= max(runs, len(EDGES) + 1)  # one in every stratum that there is
    assert found.failed.sum() == sum(pick % 7 == 0 for pick in seen)
    assert found.rate.low <= found.rate.value <= found.rate.high


def test_whoever_runs_through_all_draws_knows_the_rate():
    failed, near = law(0.5)
    found = estimate(near, lambda picks: failed[picks], 10 * DRAWS, rng(7, "test"))
    assert found.runs.sum() > 0.99 * DRAWS
    assert found.rate.value == pytest.approx(failed.mean(), rel=0.02)


def test_intervals_hold_the_rate_and_nearness_that_tells_saves_runs():
    failed, near = law(1.0)
    found = verified(failed[None], near[None], Trial(1000, 5000, 200), 20, rng(7, "test"))
    assert found["rate"] == failed.mean()
    assert found["covered"] >= 0.94
    assert found["covered_plain"] >= 0.92
    assert found["saves"] > 4
    assert abs(found["bias"]) < 0.1
    assert 1000 < found["runs"] <= 1020


def test_who_runs_through_all_draws_knows_no_more_of_the_law_than_as_many_plain_runs_do():
    failed, near = law(0.0)
    found = verified(failed[None], near[None], Trial(10 * DRAWS, 10, 5), 0, rng(7, "test"))
    assert found["saves"] == pytest.approx(1.0, abs=0.02)


def test_nearness_that_tells_nothing_costs_width_and_not_truth():
    failed, near = law(0.0)
    found = verified(failed[None], near[None], Trial(1000, 1000, 200), 0, rng(7, "test"))
    assert found["covered"] >= 0.94
    assert found["saves"] < 1.3
    assert found["width"] > 0.9 * found["width_plain"]


def test_who_never_fails_has_a_rate_of_0_and_intervals_that_say_so():
    _, near = law(1.0)
    found = verified(np.zeros((1, DRAWS), np.bool_), near[None], Trial(500, 500, 20), 0, rng(7, "test"))
    assert (found["rate"], found["covered"], found["saves"], found["bias"]) == (0.0, 1.0, None, None)
