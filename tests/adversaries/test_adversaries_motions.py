"""Candidates that are perturbed tracks."""

import numpy as np
import pytest

from drivegen.adversaries.advsim import Settings as AdvSim
from drivegen.adversaries.advsim import _Search
from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.adversaries.shared.goals import exchanged_goals
from drivegen.adversaries.shared.ground import sampled
from drivegen.adversaries.shared.motions import Perturbation, exchanged_motions
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET
from drivegen.core.settings import build, read_section
from drivegen.drivers import idm
from drivegen.rollout.choices import choose
from drivegen.selectors.random import Plugin as Random
from tests.checking import IDM, LIMITS
from tests.models import ROOT, candidate_settings, planner
from tests.scenes import busy_crossing, drive, joined, noisy_samples, scenario, stack, straight_road

NONE, SOME = Perturbation(5, 1e-9, 1e-9), Perturbation(5, 2.0, 0.01)


@pytest.fixture(scope="module")
def arena():
    scene, other = (busy_crossing(101, f"crossing-{i}") for i in range(2))
    choices = choose([scene], Random(), candidate_settings(), 1.0)
    ground = Ground(choices, np.zeros(2, np.int64), [scene.log, scene.log], planner([scene, other]), LIMITS)
    return Arena(idm.Plugin(IDM), ground, Bounds("physical", 4, 20), 7)


def test_a_vehicle_has_as_many_as_it_has_goals_where_nothing_is_changed(arena):
    pool = exchanged_motions(arena, NONE, 2, np.array([0]))
    traffic = arena.ground.traffic[0]
    for n in np.unique(pool.vehicle).tolist():
        mine = pool.vehicle == n
        assert mine.sum() == 2 * len(arena.ground.choices[0].candidates[n])
        np.testing.assert_allclose(pool.motion.speed[mine], np.broadcast_to(traffic.speed[n], (mine.sum(), 101)), atol=0.01)
    assert len(pool)
    assert TARGET not in pool.vehicle
    assert np.isnan(pool.odds).all()


def test_traffic_of_other_scenarios_is_no_ground(arena):
    choices, other = arena.ground.choices, busy_crossing(101, "other-0")
    traffic = noisy_samples(choices[0].scenario, 2)
    assert len(sampled(choices, [traffic], 2, arena.ground.planner, LIMITS).traffic) == 2
    with pytest.raises(UnusableInput, match="the recorded traffic belongs to other scenarios"):
        sampled(choices, [noisy_samples(other, 2)], 2, arena.ground.planner, LIMITS)


def test_a_round_in_which_nothing_is_allowed_forgets_no_elite(arena):
    settings = build(AdvSim, read_section("attack.adversaries", ROOT / "params.yaml")["advsim"], "advsim")
    search = _Search(arena, 0, 1, settings)
    search.asked = search.bound * np.linspace(0.5, 0.51, 8)[:, None]
    search.tell(np.arange(8.0))
    search.asked = search.asked[:0]  # of the next round nothing was allowed
    search.tell(np.zeros(0))
    np.testing.assert_allclose(search._draw(200).mean(0) / search.bound, 0.5, atol=0.05)


def test_who_drives_out_of_the_map_is_gone_there_and_allowed():
    road = straight_road(900, 2, whole=True)
    log = stack([drive(joined(road, 0), 760, 10, 101), drive(joined(road, 1), 800, 9, 101)])
    choices = choose([scenario(road, log)], Random(), candidate_settings(), 1.0)
    arena = Arena(idm.Plugin(IDM), Ground(choices, np.zeros(1, np.int64), [log], None, LIMITS), Bounds("legal", 4, 20), 7)
    pool = exchanged_motions(arena, SOME, 40, np.array([0]))
    gone = ~pool.motion.valid[:, -1]
    assert gone.any()
    assert not gone.all()
    assert (pool.motion.position[..., 0][pool.motion.valid] < 900 - 2.25).all()  # its front, at a slight angle


def test_tracks_differ_are_possible_and_the_same_in_scenes_of_one_scenario(arena):
    pool = exchanged_motions(arena, SOME, 1, np.array([0, 1]))
    first, second = (pool.motion[np.flatnonzero(pool.scene == s)] for s in (0, 1))
    np.testing.assert_array_equal(first.position, second.position)
    assert len(np.unique(first.position[:, -1, 0])) == len(first.valid)
    assert arena.allows(pool.scene, pool.vehicle, pool.motion).all()
    assert len(pool) < 2 * sum(len(each) for each in arena.ground.choices[0].candidates)  # some run into others


def test_goals_and_motions_are_made_once_an_arena(arena):
    scenes = np.array([0])
    assert exchanged_motions(arena, SOME, 1, scenes) is exchanged_motions(arena, SOME, 1, scenes)
    assert exchanged_goals(arena, 1, scenes) is exchanged_goals(arena, 1, scenes)
