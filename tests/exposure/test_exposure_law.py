"""The natural law: draws against the enumeration of all scenes, and whole legal scenes."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from drivegen.checker.scene import SceneChecker, check_samples
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.core.seeds import rng
from drivegen.exposure.law import NaturalLaw
from drivegen.goals.joint import PENALTY
from drivegen.rollout.choices import Choices, choose
from drivegen.rollout.models import Equipment
from drivegen.rollout.towards import plan_all_goals
from tests.models import candidate_settings, two_lanes
from tests.scenes import busy_crossing

FEW = 6


@pytest.fixture(scope="module")
def equipment(models) -> Equipment:
    return Equipment.open(models, "route_fm", "random")


def law_of(scene, equipment, most: int | None = None) -> tuple[NaturalLaw, Choices, Trajectories]:
    """Of a scene whose vehicles have `most` goals each, those of an early plan, and odds of 1 : 2 : 3 ..."""
    [choice] = choose([scene], equipment.selector, candidate_settings(), 1.0)
    if most is not None:
        natural = []
        for odds in choice.natural:
            some = np.zeros(len(odds), np.float32)
            rows = np.linspace(0, len(odds) - 1, most).astype(int)
            some[rows] = np.arange(1, most + 1)
            natural.append(some / some.sum())
        choice = replace(choice, natural=natural)
    [planned] = plan_all_goals([choice], equipment.planner, 7)
    return NaturalLaw.of(choice, scene.log, planned, equipment.limits), choice, planned


def test_draws_are_as_frequent_as_enumeration_says(equipment):
    law, _, _ = law_of(two_lanes(9.0), equipment, FEW)
    goals = [range(low, high) for low, high in zip(law.start[:-1], law.start[1:], strict=True)]
    every = np.array(list(product(*goals)))
    excluded = sum(law.exclusive[every[:, i], every[:, j]].astype(int) for i in range(len(goals)) for j in range(i))
    weight = np.prod(law.odds[every], axis=1, dtype=np.float64) * np.exp(-PENALTY * excluded) * law.legal(every)
    chance = weight / weight.sum()
    drawn = law.draw(4000, 200_000, rng(7, "draw"))
    assert len(drawn) == 4000
    assert 30 < (weight > 0).sum() < 0.5 * len(every)  # it is a law with something to reject
    names = np.array([law.odds.size ** np.arange(len(goals))])
    seen = np.isin((drawn * names).sum(1), (every[weight > 0] * names).sum(1))
    assert seen.all()
    for m, own in enumerate(goals):
        for goal in own:
            expected = chance[every[:, m] == goal].sum()
            assert (drawn[:, m] == goal).mean() == pytest.approx(expected, abs=0.03)
    for i, j in ((0, 2), (1, 3)):  # a leader and its follower, as they are drawn together
        both = [(a, b) for a in goals[i] for b in goals[j]]
        ours = np.array([((drawn[:, i] == a) & (drawn[:, j] == b)).mean() for a, b in both])
        theirs = np.array([chance[(every[:, i] == a) & (every[:, j] == b)].sum() for a, b in both])
        np.testing.assert_allclose(ours, theirs, atol=0.03)


@pytest.mark.parametrize("scene", [busy_crossing(), two_lanes(9.0)], ids=["crossing", "lanes"])
def test_scenes_are_legal_as_a_whole_and_the_target_moves_as_it_did(scene, equipment):
    law, choice, _ = law_of(scene, equipment)
    rows = law.draw(20, 20_000, rng(7, "draw"))
    assert len(rows) == 20
    motion = law.scenes(rows)
    violation, _ = check_samples(choice.scenario, motion, equipment.limits)
    assert not violation.any()
    np.testing.assert_array_equal(
        motion.position[:, TARGET], np.broadcast_to(scene.log.position[TARGET], motion.position[:, 0].shape)
    )
    assert len(np.unique(rows, axis=0)) > 10


def test_who_is_not_there_does_not_draw_and_a_goal_that_is_illegal_alone_is_nobodys(equipment):
    scene = two_lanes(9.0)
    valid = scene.log.valid.copy()
    valid[2] = False
    _, choice, planned = law_of(scene, equipment)
    law = NaturalLaw.of(choice, replace(scene.log, valid=valid), planned, equipment.limits)
    assert 2 not in law.vehicle
    owner = np.repeat(law.vehicle, np.diff(law.start))
    assert not SceneChecker(scene, equipment.limits).alone(owner, law.motion).violation.any()
    assert not law.scenes(law.draw(3, 1000, rng(7, "draw"))).valid[:, 2].any()


def test_where_hardly_anything_is_legal_there_are_few_draws(equipment):
    scene = two_lanes(9.0)
    [choice] = choose([scene], equipment.selector, candidate_settings(), 1.0)
    [planned] = plan_all_goals([choice], equipment.planner, 7)
    backwards = replace(scene.log, position=scene.log.position[:, ::-1].copy())  # the target's own plan is not legal
    law = NaturalLaw.of(choice, backwards, planned, equipment.limits)
    assert len(law.draw(5, 512, rng(7, "draw"))) == 0
