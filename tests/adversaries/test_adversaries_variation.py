"""Goals near good ones: planned towards places near theirs, judged as goals are, and none of what has no goal."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.adversaries.shared.goals import EULER_STEPS, exchanged_goals
from drivegen.adversaries.shared.motions import Perturbation, exchanged_motions
from drivegen.adversaries.shared.shift import Shift
from drivegen.adversaries.shared.variation import Variation, odds_of_nearest, with_variations
from drivegen.core.scenario import Trajectories
from drivegen.drivers import idm
from drivegen.rollout.choices import choose
from drivegen.rollout.towards import Spread, plan_near_goals
from drivegen.selectors.random import Plugin as Random
from tests.checking import IDM, LIMITS
from tests.models import candidate_settings, planner, two_lanes

SHIFT, NO_SHIFT = Shift(3.0, 3.0, 6.0), Shift(0.0, 3.0, 6.0)
NOWHERE, NEAR = Spread(0.0, 0.0, 0.0), Spread(10.0, 0.3, 2.0)


@pytest.fixture(scope="module")
def arena():
    scenes = [two_lanes(8.0, "queue8-0"), two_lanes(9.0, "queue9-0")]
    choices = choose(scenes, Random(), candidate_settings(), 1.0)
    ground = Ground(choices, np.array([0, 1]), [scene.log for scene in scenes], planner(scenes), LIMITS)
    return Arena(idm.Plugin(IDM), ground, Bounds("legal", 4, 20), 7)


def varied(arena, variation, order=None):
    pool = exchanged_goals(arena, 1, np.arange(2))
    return pool, with_variations(arena, pool, np.arange(len(pool)) if order is None else order, variation)


def test_the_pool_comes_first_then_what_is_allowed_of_the_best_of_each_scene(arena):
    pool, whole = varied(arena, Variation(3, 5, NEAR, NO_SHIFT))
    count = len(pool)
    np.testing.assert_array_equal(whole.motion.position[:count, :101], pool.motion.position)
    assert count < len(whole) <= count + 2 * 3 * 5
    for scene in range(2):
        best = {(pool.vehicle[q], pool.goal[q]) for q in np.flatnonzero(pool.scene == scene)[:3]}
        mine = np.flatnonzero(whole.scene[count:] == scene) + count
        assert {(whole.vehicle[q], whole.goal[q]) for q in mine} <= best
    new = slice(count, None)
    assert arena.allows(whole.scene[new], whole.vehicle[new], whole.motion[count:]).all()


def test_a_variation_has_the_odds_of_the_goal_nearest_to_where_it_ends(arena):
    n = int(exchanged_goals(arena, 1, np.arange(2)).vehicle[0])
    goals, odds = arena.ground.choices[0].candidates[n], arena.ground.choices[0].natural[n]
    first, faster = np.arange(len(goals)), goals.speed[0] + 40.0
    track = Trajectories.empty(len(goals) + 1, 101)
    track.position[:], track.valid[:, :50] = 1e6, True  # where it is no longer there, nothing counts
    track.position[:, 49] = goals.position[[*first, 0]]
    track.velocity[:, 49, 0] = [*goals.speed, faster]
    found = odds_of_nearest(arena.ground, np.zeros(len(goals) + 1, np.int64), np.full(len(goals) + 1, n), track)
    assert found[:-1].tolist() == odds.tolist()
    apart = np.hypot(np.hypot(*(goals.position - goals.position[0]).T), 2 * (goals.speed - faster))
    assert apart.argmin() > 0
    assert found[-1] == odds[apart.argmin()]


def test_without_spread_only_the_planners_noise_differs_and_with_it_ends_do(arena):
    def ends(spread):
        pool, whole = varied(arena, Variation(2, 8, spread, NO_SHIFT))
        of = {(s, n, g): q for q, (s, n, g) in enumerate(zip(pool.scene, pool.vehicle, pool.goal, strict=True))}
        count = len(pool)
        keys = zip(whole.scene[count:], whole.vehicle[count:], whole.goal[count:], strict=True)
        origin = pool.motion.position[[of[key] for key in keys], -1]
        return np.hypot(*(whole.motion.position[count:, -1] - origin).T)

    assert ends(NOWHERE).max() < 0.1
    assert ends(NEAR).std() > 1


def test_who_drives_never_stands_at_once_however_near_a_place_would_be(arena):
    choices = arena.ground.choices
    rows = [np.array([(k, 1, len(c.candidates[1]) - 1, 0) for k in range(30)], np.int64) for c in choices]
    planned = plan_near_goals(choices, rows, Spread(1000.0, 0.0, 0.0), arena.ground.planner, 7)
    for choice, motion in zip(choices, planned, strict=True):
        speed = float(choice.scenario.vehicles.speed[1])
        went = np.hypot(*np.diff(motion.position[:, :2], axis=1)[:, 0].T) / 0.1
        assert speed > 5
        assert went.min() > speed - 1.0


def test_several_motions_towards_a_goal_are_one_goal_and_every_variation_starts_where_its_vehicle_stands(arena):
    once = varied(arena, Variation(3, 5, NEAR, NO_SHIFT))
    pool = exchanged_goals(arena, 2, np.arange(2))
    first = [np.flatnonzero((pool.scene == s) & (pool.vehicle == n) & (pool.goal == g))[0]
             for s, n, g in zip(once[0].scene, once[0].vehicle, once[0].goal, strict=True)]  # fmt: skip
    order = np.array([*first, *np.setdiff1d(np.arange(len(pool)), first)])
    whole = with_variations(arena, pool, order, Variation(3, 5, NEAR, NO_SHIFT))
    here, there = slice(len(once[0]), None), slice(len(pool), None)
    np.testing.assert_array_equal(whole.motion.position[there], once[1].motion.position[here])
    start = np.array([arena.trials.scenarios[s].vehicles.position[n] for s, n in zip(whole.scene, whole.vehicle, strict=True)])
    assert np.hypot(*(whole.motion.position[:, 0] - start).T).max() < 1e-3


def test_nothing_is_varied_where_none_is_asked_for_or_nothing_has_a_goal(arena):
    pool, whole = varied(arena, Variation(0, 5, NEAR, SHIFT))
    assert whole is pool
    tracks = exchanged_motions(arena, Perturbation(3, 1.0, 0.005), 1, np.arange(2))
    assert with_variations(arena, tracks, np.arange(len(tracks)), Variation(3, 5, NEAR, NO_SHIFT)) is tracks


def test_behind_the_variations_are_those_that_are_there_throughout_once_more_shifted_across(arena):
    pool, plain = varied(arena, Variation(3, 5, NEAR, NO_SHIFT))
    whole = with_variations(arena, pool, np.arange(len(pool)), Variation(3, 5, NEAR, SHIFT))
    for field in ("position", "heading", "velocity", "valid"):
        np.testing.assert_array_equal(getattr(whole.motion, field)[: len(plain)], getattr(plain.motion, field))
    shifted = np.arange(len(plain), len(whole))
    assert len(shifted)
    assert whole.motion.valid[shifted].all()
    for q in shifted.tolist():
        across = np.abs(whole.motion.position[q, :, 1] - plain.motion.position[plain.vehicle == whole.vehicle[q], :, 1])
        assert across.max(axis=1).min() > 1e-3  # from every track of its vehicle, on a road along x
    assert arena.allows(whole.scene[shifted], whole.vehicle[shifted], whole.motion[shifted]).all()


def test_a_scene_has_the_same_variations_whoever_is_beside_it(arena):
    pool, whole = varied(arena, Variation(2, 4, NEAR, SHIFT))
    second = np.flatnonzero(pool.scene == 1)
    _, alone = varied(arena, Variation(2, 4, NEAR, SHIFT), second)
    mine = np.flatnonzero(whole.scene[len(pool) :] == 1) + len(pool)
    np.testing.assert_array_equal(alone.motion.position[len(pool) :], whole.motion.position[mine])
    assert replace(alone, motion=None).vehicle[len(pool) :].tolist() == whole.vehicle[mine].tolist()


def test_adversaries_hurry_a_planner_by_flow_and_leave_it_as_it_was(arena):
    slow, whole = arena.ground.planner.in_steps(8), varied(arena, Variation(3, 5, NEAR, NO_SHIFT))[1]
    other = Arena(idm.Plugin(IDM), replace(arena.ground, planner=slow), arena.bounds, arena.seed)
    np.testing.assert_array_equal(varied(other, Variation(3, 5, NEAR, NO_SHIFT))[1].motion.position, whole.motion.position)
    assert arena.ground.planner.euler_steps == EULER_STEPS < slow.euler_steps
