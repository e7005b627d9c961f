"""Rates of failure from strata: intervals against textbook ones, and against laws whose rate is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from drivegen.core.seeds import rng
from drivegen.corner_cases.rates import EDGES, Strata, Trial, rate, strata, verified

DRAWS = 60_000


def law(knows: float) -> tuple[np.ndarray, np.ndarray]:
    """Who fails in draws of which one in fifty is hard: the driver in a tenth of these and in one in 10 000 of the others.

    Eight of a house fail in half of those that are hard, or as often anywhere else where they know nothing of it (`knows` 0).
    """
    random = rng(7, "law")
    hard, guess = random.random(DRAWS) < 0.02, random.random(DRAWS) < 0.02
    failed = random.random(DRAWS) < np.where(hard, 0.1, 1e-4)
    seen = np.where(random.random(DRAWS) < knows, hard, guess)
    return failed, (random.random((DRAWS, 8)) < 0.5) & seen[:, None]


def test_one_stratum_has_garwoods_exact_interval():
    interval = rate(np.ones(1), np.array([3]), np.array([1000]))
    low, high = chi2.ppf(0.025, 6) / 2000, chi2.ppf(0.975, 8) / 2000
    np.testing.assert_allclose([interval.value, interval.low, interval.high], [0.003, low, high], rtol=1e-9)


def test_no_failure_leaves_what_few_runs_cannot_rule_out():
    interval = rate(np.array([0.9, 0.1]), np.array([0, 0]), np.array([90, 100]))
    assert (interval.value, interval.low) == (0.0, 0.0)
    assert interval.high == pytest.approx(0.01 * -np.log(0.025))  # the heaviest run weighs 0.9 / 90


@given(st.lists(st.tuples(st.integers(1, 50), st.integers(0, 5)), min_size=1, max_size=6))
def test_interval_is_that_of_fay_and_feuer(counts):
    runs, failed = (np.array(column) for column in zip(*counts, strict=True))
    share = np.full(len(runs), 1 / len(runs))
    interval = rate(share, failed, runs)
    value = sum(s * f / n for s, f, n in zip(share, failed, runs, strict=True))
    variance = sum(s**2 * f / n**2 for s, f, n in zip(share, failed, runs, strict=True))
    most = max(s / n for s, n in zip(share, runs, strict=True))
    more, wider = value + most, variance + most**2
    assert interval.value == pytest.approx(value)
    assert interval.low == pytest.approx(variance / (2 * value) * chi2.ppf(0.025, 2 * value**2 / variance) if value else 0.0)
    assert interval.high == pytest.approx(wider / (2 * more) * chi2.ppf(0.975, 2 * more**2 / wider))


def test_draws_are_sorted_by_how_many_of_the_house_fail():
    house = np.arange(12)[None] < np.array([0, 1, 2, 3, 4, 5, 8, 9, 12])[:, None]
    np.testing.assert_array_equal(strata(house), [0, 1, 2, 3, 3, 4, 4, 5, 5])
    np.testing.assert_allclose(Strata.of(house).share, np.array([1, 1, 1, 2, 2, 2]) / 9)


def test_runs_are_made_where_others_fail_and_somewhere_in_every_stratum():
    _, house = law(1.0)
    found = Strata.of(house)
    made = found.allocate(1000)
    assert made.sum() <= 1000 + len(EDGES)
    np.testing.assert_array_equal(made > 0, found.share > 0)
    density = made[found.share > 0] / found.share[found.share > 0]
    assert (density[1:] > 3 * density[0]).all()


def test_intervals_hold_the_rate_and_a_house_that_knows_saves_runs():
    failed, house = law(1.0)
    found = verified(failed, house, Trial(1000, 20_000, 400), rng(7, "test"))
    assert found["rate"] == failed.mean()
    assert found["covered"] >= 0.94
    assert found["covered_plain"] >= 0.93
    assert found["saves"] > 4


def test_a_house_that_knows_nothing_costs_width_and_not_truth():
    failed, house = law(0.0)
    found = verified(failed, house, Trial(4000, 4000, 400), rng(7, "test"))
    assert found["covered"] >= 0.94
    assert found["saves"] < 1.1
    assert found["width"] > found["width_plain"]


def test_estimates_are_not_biased():
    failed, house = law(0.5)
    found, at = Strata.of(house), strata(house)
    made = found.allocate(2000)
    within = np.bincount(at, failed, len(made)) / np.maximum(np.bincount(at, minlength=len(made)), 1)
    values = rate(found.share, rng(7, "bias").binomial(made, within, (4000, len(made))), made).value
    assert np.mean(values) == pytest.approx(failed.mean(), abs=4 * np.std(values) / np.sqrt(4000))


def test_who_never_fails_has_a_rate_of_0_and_intervals_that_say_so():
    _, house = law(1.0)
    found = verified(np.zeros(DRAWS, np.bool_), house, Trial(500, 500, 20), rng(7, "test"))
    assert (found["rate"], found["covered"], found["saves"]) == (0.0, 1.0, None)
