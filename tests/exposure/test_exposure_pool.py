"""The pool of draws: single picks against whole scenes, and how near others come against a hand case."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.adversaries.shared.ground import logged
from drivegen.core.seeds import rng
from drivegen.drivers import idm
from drivegen.exposure.pool import Exposure, Pool, draw_scenes, with_enough
from drivegen.rollout.choices import choose
from drivegen.rollout.models import Equipment
from drivegen.world.observation import Action, Observation
from drivegen.world.reactive import Reaction
from tests.checking import IDM
from tests.models import candidate_settings, two_lanes

DRAWS = 24
REACTION = Reaction(delay=0.75, braking=6.0, headway=0.6, min_gap=1.0, acceleration=1.5, comfort=3.0)


class Blind:
    """Sees nobody and accelerates."""

    name, settings_type = "blind", type(None)

    def act(self, seen: Observation) -> Action:
        return Action(0 * seen.speed + 2.0)


DRIVERS = [Blind(), idm.Plugin(IDM)]


@pytest.fixture(scope="module")
def drawn(models):
    """Two queues, one of which lasts for six seconds only."""
    tools = Equipment.open(models, "route_fm", "random")
    scenes = [two_lanes(9.0, "long-0"), two_lanes(8.0, "short-0", steps=61)]
    ground = logged(choose(scenes, tools.selector, candidate_settings(), 1.0), tools.planner, tools.limits)
    return list(draw_scenes(ground, DRAWS, 4096, 7))


def test_a_draw_picked_alone_ends_as_it_does_among_all(drawn):
    whole = Exposure.of(drawn, DRIVERS, DRAWS, REACTION)
    assert whole.failed.shape == whole.near.shape == (2, DRAWS, 2)
    assert whole.failed.any()
    assert not whole.failed.all()
    assert whole.failed.sum() > 0
    assert 0 < whole.seconds[0] < 10.0  # runs end where somebody collides
    assert 0 < whole.seconds[1] <= 6.0
    pool = Pool(drawn, DRIVERS[0], REACTION)
    picks = rng(7, "picks").permutation(len(pool))[: len(pool) // 2]
    for m, driver in enumerate(DRIVERS):
        np.testing.assert_array_equal(pool.failed(driver, picks), whole.failed[:, :, m].ravel()[picks])
        np.testing.assert_array_equal(pool.near(pool.first(driver)), whole.near[:, :, m].ravel())
    assert len(pool.failed(DRIVERS[0], picks[:0])) == 0


def test_who_fails_is_come_near_to_and_where_nobody_is_there_nobody_is_near(drawn):
    whole = Exposure.of(drawn, DRIVERS[:1], DRAWS, REACTION)
    assert np.median(whole.near[whole.failed]) < np.median(whole.near[~whole.failed])
    alone = [
        replace(one, law=replace(one.law, vehicle=one.law.vehicle[:0], start=one.law.start[:1]), rows=one.rows[:, :0])
        for one in drawn
    ]
    alone = [replace(one, law=replace(one.law, motion=one.law.motion[:0])) for one in alone]
    pool = Pool(alone, DRIVERS[0], REACTION)
    assert np.isinf(pool.near(pool.first(DRIVERS[0]))).all()


def test_scenes_with_too_few_draws_are_named(drawn):
    few = replace(drawn[0], rows=drawn[0].rows[:3])
    scenes, left_out = with_enough([few, drawn[1]], DRAWS)
    assert (scenes, left_out) == ([drawn[1]], ["long-0"])
    nothing = Exposure.of([few], DRIVERS, DRAWS, REACTION)
    assert nothing.left_out == ["long-0"]
    assert nothing.failed.shape == (0, DRAWS, 2)
