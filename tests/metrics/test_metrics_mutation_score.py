"""The mutation score: exact tests against other ways to compute them, who is killed, what is named, how often by mistake."""

from itertools import product

import numpy as np
import pytest
from scipy.stats import binomtest

from drivegen.metrics.mutation_score import Pairs, Settings, holm, names, scored
from drivegen.metrics.paired import chance

HOW = Settings(0.05, (10, 40, 400), 40)
RNG = np.random.default_rng(7)


def pairs(excess, recordings=None, kind="rear", turn=None):
    """Runs with `excess` (R,), each in a recording of its own where none are given."""
    excess = np.asarray(excess)
    recordings = np.arange(len(excess)) if recordings is None else recordings
    scenario = np.array([f"file{r}-{n}" for n, r in enumerate(recordings)])
    turns = np.zeros(len(excess), np.int64) if turn is None else np.asarray(turn)
    return Pairs(scenario, turns, np.where(excess > 0, kind, "").astype(object), np.where(excess < 0, kind, "").astype(object))


@pytest.mark.parametrize(("more", "less"), [(0, 0), (1, 0), (5, 5), (9, 1), (1, 9), (60, 31)])
def test_without_clusters_it_is_the_exact_test_of_mcnemar(more, less):
    expected = binomtest(more, more + less, alternative="greater").pvalue if more + less else 1.0
    assert chance(np.array([1] * more + [-1] * less + [0, 0])) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("excess", [[3], [3, -1], [2, 2, 2], [5, -4, 1, 0, 1], [-2, -2, 1], [7, 3, -3, 2, 1, 1, -1]])
def test_clusters_are_tossed_as_a_whole(excess):
    excess = np.array(excess)
    sums = [np.dot(signs, np.abs(excess)) for signs in product((-1, 1), repeat=len(excess))]
    assert chance(excess) == pytest.approx(np.mean(np.array(sums) >= excess.sum()), abs=1e-15)


def test_many_failures_of_one_recording_are_worth_no_more_than_one():
    assert chance(np.array([40])) == 0.5
    assert chance(np.ones(40, np.int64)) < 1e-12


def test_holm_goes_on_as_long_as_each_next_one_passes():
    assert holm(np.array([0.04, 0.01, 0.03, 0.005]), 0.05).tolist() == [False, True, False, True]  # 0.03 > 0.05 / 2
    assert holm(np.array([0.013, 0.03, 0.016, 0.02]), 0.05).tolist() == [False] * 4  # 0.013 > 0.05 / 4: none after it, either
    p = RNG.uniform(0, 0.05, (200, 6))
    for each in p:
        order = np.argsort(each)
        adjusted = np.empty(6)
        adjusted[order] = np.maximum.accumulate(each[order] * np.arange(6, 0, -1))
        assert holm(each, 0.05).tolist() == (adjusted <= 0.05).tolist()


def test_a_kind_is_named_if_nothing_else_has_a_larger_excess():
    assert names({"rear": 3, "merge": 3, "standing": -1}, ("merge",))
    assert not names({"rear": 3, "merge": 2}, ("merge",))
    assert not names({"rear": 0, "merge": 0}, ("merge",))
    assert not names({}, ("merge",))


def test_a_score_by_hand():
    bad, same = pairs([1] * 20 + [0] * 20), pairs([0] * 40)
    one_file = pairs([1] * 20 + [0] * 20, [0] * 20 + list(range(1, 21)))
    fails = {"bad": ("rear",), "wrong": ("merge",), "one_file": ("rear",), "same": ()}
    score = scored({"bad": bad, "wrong": bad, "one_file": one_file, "same": same}, fails, HOW, np.random.default_rng(1))
    assert (score["faulty"], score["equivalent"], score["runs"], score["recordings"]) == (3, 1, 40.0, 40)
    assert score["killed"] == pytest.approx(2 / 3)
    assert score["killed_apart"] == 1.0  # whoever takes runs of one recording as independent kills on its strength alone
    assert (score["false_kills"], score["named"], score["named_by_guess"]) == (0.0, 0.5, 0.5)
    assert score["drivers"]["bad"] == {
        "runs": 40, "only_mutant": 20, "only_sound": 0, "p": 0.5**20, "killed": True, "killed_apart": True,
        "kinds": {"rear": 20}, "fails": ["rear"], "named": True, "runs_to_kill": 40.0,
    }  # fmt: skip
    looks, killed = score["curve"]
    assert looks == [10, 40]  # all runs are the last look
    assert killed[0] < 0.1  # five of ten runs fail, and 0.05 / 4 takes seven
    assert killed[1] == pytest.approx(2 / 3)
    assert (score["first_kill"], score["runs_to_kill"]) == (40.0, 40.0)
    assert scored({"same": same}, fails, HOW, RNG)["killed"] is None


def test_runs_of_an_earlier_turn_come_first_and_those_of_a_scenario_stay_together():
    late = pairs([0] * 10 + [1] * 30, [*range(10), *range(10), *range(10), *range(10)], turn=np.repeat([0, 1, 2, 3], 10))
    early = pairs([1] * 10 + [0] * 30, [*range(10)] * 4, turn=np.repeat([0, 1, 2, 3], 10))
    how = Settings(0.05, (10, 20), 5)
    assert scored({"late": late}, {"late": ("rear",)}, how, RNG)["first_kill"] == 20
    assert scored({"early": early}, {"early": ("rear",)}, how, RNG)["first_kill"] == 10


def test_scenarios_sums_are_those_of_their_runs():
    ids, sums = Pairs.joined([pairs([1, -1], [4, 4]), pairs([1, 0], [4, 5])]).by_scenario()
    assert ids == ["file4-0", "file4-1", "file5-1"]
    assert {name: value.tolist() for name, value in sums.items()} == {
        "runs": [2, 1, 1], "failed": [2, 0, 0], "failed_sound": [0, 1, 0], "only_mutant": [2, 0, 0], "only_sound": [0, 1, 0],
    }  # fmt: skip


def test_drivers_that_differ_by_chance_alone_are_killed_no_more_often_than_is_said():
    """Eight of them, none worse: runs of a recording flip together, which is what clusters are for."""
    random, mistakes, naive, times = np.random.default_rng(3), 0, 0, 300
    for _ in range(times):
        side = random.choice([-1, 1], (8, 20, 1))
        flips = side * (random.random((8, 20, 10)) < 0.4)  # 20 recordings, in each of which one of the two is worse
        drivers = {str(m): pairs(one.ravel(), np.repeat(np.arange(20), 10)) for m, one in enumerate(flips)}
        p = np.array([chance(one.sum(axis=1)) for one in flips])
        apart = np.array([chance(one.ravel()) for one in flips])
        mistakes += holm(p, 0.05).any()
        naive += holm(apart, 0.05).any()
    assert mistakes / times <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / times)
    assert naive / times > 0.3  # and this is what they are for
    score = scored(drivers, dict.fromkeys(drivers, ()), Settings(0.05, (50,), 2), random)
    assert score["false_kills"] == holm(p, 0.05).mean()
    assert score["false_kills_apart"] == holm(apart, 0.05).mean()
