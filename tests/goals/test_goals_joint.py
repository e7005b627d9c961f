"""Goals drawn together: the vehicles' own odds, conditioned on what excludes each other."""

import numpy as np

from drivegen.goals.joint import draw_together, gumbel

MANY = 4000


def drawn(used, start, exclusive):
    used = np.float32(used)
    return draw_together(used, np.array(start), np.asarray(exclusive, bool), gumbel(7, "scene", MANY, len(used)))


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


def test_what_has_no_probability_is_never_drawn_not_even_to_escape():
    exclusive = np.zeros((4, 4))
    exclusive[0, 2] = exclusive[2, 0] = 1
    goals = drawn([1.0, 0.0, 1.0, 0.0], [0, 2, 4], exclusive)
    assert not goals.any()


def test_a_draw_depends_on_the_seed_and_the_scenario_alone():
    np.testing.assert_array_equal(gumbel(7, "a", 3, 5), gumbel(7, "a", 3, 5))
    assert (gumbel(7, "a", 3, 5) != gumbel(7, "b", 3, 5)).any()
    assert (gumbel(7, "a", 3, 5) != gumbel(8, "a", 3, 5)).any()
