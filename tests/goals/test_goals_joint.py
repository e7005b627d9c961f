"""Goals drawn together: the vehicles' own odds, conditioned on what excludes each other."""

import numpy as np
import pytest

from drivegen.goals.joint import SWEEPS, draw_together, gumbel, in_tempo, orders, tempos

MANY = 4000


def drawn(used, start, exclusive):
    used, order = np.float32(used), orders(np.random.default_rng(7), SWEEPS, MANY, len(start) - 1)
    return draw_together(used, np.array(start), np.asarray(exclusive, bool), gumbel(7, "scene", MANY, len(used)), order)


def test_without_exclusions_every_vehicle_keeps_its_own_odds():
    used = [0.7, 0.3, 0.1, 0.2, 0.7]
    goals = drawn(used, [0, 2, 5], np.zeros((5, 5)))
    np.testing.assert_allclose(np.bincount(goals[:, 0]) / MANY, used[:2], atol=0.03)
    np.testing.assert_allclose(np.bincount(goals[:, 1]) / MANY, used[2:], atol=0.03)


def test_excluded_pairs_are_left_out_and_the_rest_keeps_its_proportions():
    """p(c1) p(c2) without the pair (0, 0), normalised."""
    exclusive = np.zeros((4, 4))
    exclusive[0, 2] = exclusive[2, 0] = 1
    goals = drawn([0.6, 0.4, 0.5, 0.5], [0, 2, 4], exclusive)
    joint = np.histogram2d(*goals.T, bins=[[-0.5, 0.5, 1.5]] * 2)[0] / MANY
    wanted = np.array([[0.0, 0.3], [0.2, 0.2]])
    np.testing.assert_allclose(joint, wanted / wanted.sum(), atol=0.03)


@pytest.mark.parametrize("sure", [0.9, 0.97])
def test_of_two_alike_whose_likeliest_goals_exclude_each_other_none_yields_more_often(sure):
    exclusive = np.zeros((4, 4))
    exclusive[0, 2] = exclusive[2, 0] = 1
    yields = drawn([sure, 1 - sure, sure, 1 - sure], [0, 2, 4], exclusive).mean(axis=0)
    np.testing.assert_allclose(yields, sure * (1 - sure) / (1 - sure**2) + (1 - sure) ** 2 / (1 - sure**2), atol=0.03)


def test_every_vehicle_draws_once_in_every_sweep_in_an_order_of_its_own():
    order = orders(np.random.default_rng(7), 4, 50, 3)
    assert (np.sort(order, axis=-1) == np.arange(3)).all()
    assert len(np.unique(order.reshape(-1, 3), axis=0)) == 6


def test_what_has_no_probability_is_never_drawn_not_even_to_escape():
    exclusive = np.zeros((4, 4))
    exclusive[0, 2] = exclusive[2, 0] = 1
    goals = drawn([1.0, 0.0, 1.0, 0.0], [0, 2, 4], exclusive)
    assert not goals.any()


def test_a_draw_depends_on_the_seed_and_the_scenario_alone():
    np.testing.assert_array_equal(gumbel(7, "a", 3, 5), gumbel(7, "a", 3, 5))
    assert (gumbel(7, "a", 3, 5) != gumbel(7, "b", 3, 5)).any()
    assert (gumbel(7, "a", 3, 5) != gumbel(8, "a", 3, 5)).any()


OWN = np.float32([0.2, 0.5, 0.3, 0.6, 0.0, 0.4])
START = np.array([0, 3, 6])
DISTANCE = np.array([30.0, 0.0, 60.0, 10.0, 20.0, 40.0])
"""Two vehicles; the first one's candidates are not in the order of their distances."""


def in_tempos(share):
    return in_tempo(OWN, START, DISTANCE, tempos(7, "scene", MANY), share)


def test_over_all_tempos_every_vehicle_keeps_its_own_odds_and_what_has_none_gets_none():
    odds = in_tempos(0.8)
    np.testing.assert_allclose(odds.mean(axis=0), OWN, atol=1e-3)
    np.testing.assert_allclose(np.add.reduceat(odds, START[:-1], axis=1), 1.0, atol=1e-6)
    assert not odds[:, 4].any()


def test_without_a_tempo_in_common_the_odds_are_ones_own_in_every_sample():
    np.testing.assert_allclose(in_tempos(0.0), np.broadcast_to(OWN, (MANY, 6)), atol=1e-6)


def test_in_a_brisk_sample_everybody_gets_far_and_in_a_slow_one_nobody():
    noise = gumbel(7, "scene", MANY, len(OWN))
    for share, least, most in ((0.0, -0.05, 0.05), (0.5, 0.25, 0.5), (0.9, 0.6, 1.0)):
        goals = draw_together(
            in_tempos(share), START, np.zeros((6, 6), bool), noise, orders(np.random.default_rng(7), SWEEPS, MANY, 2)
        )
        assert least <= np.corrcoef((DISTANCE[goals + START[:-1]]).T)[0, 1] <= most


def test_tempos_are_spread_evenly_and_depend_on_the_seed_and_the_scenario_alone():
    np.testing.assert_array_equal(np.sort(np.digitize(tempos(7, "scene", 4), [-0.6745, 0.0, 0.6745])), [0, 1, 2, 3])
    np.testing.assert_array_equal(tempos(7, "a", 10), tempos(7, "a", 10))
    assert (tempos(7, "a", 10) != tempos(7, "b", 10)).any()
    assert (tempos(7, "a", 10) != tempos(8, "a", 10)).any()
