"""The paired test of two drivers: by hand, against all signs counted one by one, and what it does to drivers that are alike."""

from itertools import product

import numpy as np
import pytest

from drivegen.metrics.paired import _TILTS, Finding, Paired, chance, odds


def signs(count: int) -> np.ndarray:
    """(2^count, count) all of them."""
    return np.array(list(product((-1, 1), repeat=count)))


@pytest.mark.parametrize(
    ("differences", "expected"),
    [
        ([1, 1, 1, 1, 1], 1 / 32),
        ([1, 1, 1, 1, -1], 6 / 32),
        ([3, -1, -1], 1 / 2),
        ([-3, 1, 1], 5 / 8),
        ([2, 0, 0], 1 / 2),
        ([0, 0], 1.0),
        ([], 1.0),
    ],
)
def test_chances_are_those_that_one_counts_by_hand(differences, expected):
    assert chance(np.array(differences, np.int64)) == pytest.approx(expected)


def test_a_worse_driver_in_all_recordings_and_one_in_a_single_recording():
    runs = np.ones(10, np.bool_)
    spread = Paired.of(~runs, runs, [f"recording{n}-0" for n in range(10)])
    assert spread.finding(0.05) == Finding.WORSE
    assert odds(spread.differences) > 20
    alone = Paired.of(~runs, runs, ["recording"] * 10)
    assert alone.finding(0.05) == Finding.UNDECIDED
    assert odds(alone.differences) < 2
    assert np.isnan(alone.noticed(0.05))


def test_runs_are_counted_and_differences_summed_by_recording():
    old, new = np.array([1, 1, 0, 0, 1], np.bool_), np.array([1, 0, 1, 1, 1], np.bool_)
    paired = Paired.of(old, new, ["b", "a", "b", "b", "a"])
    assert (paired.runs, paired.old, paired.new, paired.only_old, paired.only_new) == (5, 3, 4, 1, 2)
    assert paired.differences.tolist() == [-1, 2]


@pytest.mark.parametrize("seed", range(12))
def test_chance_and_odds_are_those_of_all_signs_counted_one_by_one(seed):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(0, 9, rng.integers(1, 11))
    differences = sizes * rng.choice([-1, 1], len(sizes))
    sums = signs(len(sizes)) @ sizes
    assert chance(differences) == pytest.approx((sums >= differences.sum()).mean())
    by_tilt = [np.prod(np.exp(tilt * differences) / np.cosh(tilt * differences)) for tilt in _TILTS]
    assert odds(differences) == pytest.approx(np.mean(by_tilt))


@pytest.mark.parametrize("sizes", [[1] * 9, [1, 2, 3, 4, 5, 6, 7], [40, 1, 1, 1, 1, 1], [5, 5, 5, 0, 2]])
def test_of_alike_drivers_no_more_than_asked_are_called_worse_and_odds_are_fair(sizes):
    all_signs = signs(len(sizes)) * np.array(sizes)
    chances, values = np.array([chance(d) for d in all_signs]), np.array([odds(d) for d in all_signs])
    for alarms in (0.01, 0.05, 0.1, 0.3):
        assert (chances <= alarms).mean() <= alarms
    assert values.mean() == pytest.approx(1.0)
    for x in (2, 5, 20):
        assert (values >= x).mean() <= 1 / x


def test_odds_stay_fair_where_one_stops_at_the_best_moment():
    best = [max(odds(np.array(d[:n])) for n in range(1, 11)) for d in signs(10) * np.array([1, 2, 1, 5, 1, 3, 1, 1, 2, 4])]
    for x in (1.5, 2, 5, 10):
        assert np.mean(np.array(best) >= x) <= 1 / x


def test_odds_do_not_leave_the_numbers():
    assert 1e300 < odds(np.full(5000, 3)) < np.inf
    assert 0.0 < odds(np.full(5000, -3)) < 1e-200


def test_exchanging_the_drivers_exchanges_the_findings():
    rng = np.random.default_rng(3)
    names = [f"r{n}" for n in rng.integers(0, 30, 900)]
    old = rng.random(900) < 0.02
    new = old | (rng.random(900) < 0.03)
    one, other = Paired.of(old, new, names), Paired.of(new, old, names)
    assert (one.finding(0.05), other.finding(0.05)) == (Finding.WORSE, Finding.BETTER)
    assert one.noticed(0.05) == other.noticed(0.05) > 0


RECORDINGS, RUNS = 40, 100


def trial(rng: np.random.Generator, worse: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two drivers in 40 recordings of 100 runs; each recording has a way of its own of being hard for either of them."""
    hard = 0.02 * rng.gamma(0.5, 2.0, RECORDINGS)
    shares = [np.clip(hard * factor * rng.gamma(2.0, 0.5, RECORDINGS), 0, 1) for factor in (1.0, 1.0 + worse)]
    old, new = (rng.random((RECORDINGS, RUNS)) < share[:, None] for share in shares)
    return old.ravel(), new.ravel(), np.repeat(np.arange(RECORDINGS).astype(str), RUNS)


def alarm_rate(worse: float, by_recording: bool, trials: int = 600) -> float:
    rng = np.random.default_rng(7)
    found = 0
    for _ in range(trials):
        old, new, recordings = trial(rng, worse)
        names = recordings if by_recording else np.arange(len(old)).astype(str)
        found += Paired.of(old, new, names).finding(0.05) == Finding.WORSE
    return found / trials


def test_false_alarms_are_one_in_twenty_at_most_and_would_be_more_were_every_run_taken_alone():
    assert alarm_rate(0.0, by_recording=True) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 600)
    assert alarm_rate(0.0, by_recording=False, trials=200) > 0.1  # each takes four times as long


def test_a_driver_that_is_three_times_as_bad_is_found():
    assert alarm_rate(2.0, by_recording=True, trials=100) > 0.9
