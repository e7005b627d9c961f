"""What holds for every adversary: a file in drivegen/adversaries is found here and has to keep to it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivegen.adversaries.base import TRAFFIC, VARIES, About
from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.adversaries.shared.legal import legal
from drivegen.adversaries.shared.rules import RULES
from drivegen.checker.scene import check_samples
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET
from drivegen.core.settings import build, read_section
from drivegen.drivers import idm
from drivegen.rollout.batch import choose
from drivegen.selectors.random import Plugin as Random
from tests.checking import IDM, LIMITS
from tests.models import ROOT, candidate_settings, planner
from tests.scenes import busy_crossing

ADVERSARIES = plugins.names("adversaries")
BUDGET = 4


@pytest.fixture(scope="module")
def ground():
    scenes = [busy_crossing(101, f"crossing-{i}") for i in range(2)]
    choices = choose(scenes, Random(), candidate_settings(), 1.0)
    return Ground(choices, np.array([0, 0, 1]), [lawful(scenes[s]) for s in (0, 0, 1)], planner(scenes), LIMITS)


def lawful(scene):
    """Its log without those who break a rule."""
    samples = Samples.without_goals(scene.scenario_id, "log", scene.log[np.newaxis])
    violation, _ = check_samples(scene, samples.motion, LIMITS, ignore_target=True)
    return legal(replace(samples, violation=violation), 0)


@pytest.fixture(scope="module")
def attacked(ground):
    """The arena after an attack by its name and what is allowed, each made once."""
    return cache(lambda name, allowed: attack(name, ground, allowed))


def attack(name, ground, allowed="legal", budget=BUDGET):
    plugin = plugins.load("adversaries", name)
    settings = read_section("attack.adversaries", ROOT / "params.yaml")[name]
    arena = Arena(idm.Plugin(IDM), ground, Bounds(allowed, budget, 20), 7)
    plugin(build(plugin.settings_type, settings, name)).attack(arena)
    return arena


@pytest.mark.parametrize("name", ADVERSARIES)
def test_it_says_what_it_is(name):
    about = About(**plugins.about("adversaries", name))
    assert about.title
    assert about.traffic in TRAFFIC
    assert about.varies in VARIES


def test_a_rule_that_is_none_is_refused():
    with pytest.raises(UnusableInput, match="allowed is physical or legal, not 'lawful'"):
        Bounds("lawful", BUDGET, 20)


@pytest.mark.parametrize("allowed", RULES)
@pytest.mark.parametrize("name", ADVERSARIES)
def test_it_keeps_to_its_budget_and_to_what_is_allowed(name, allowed, ground, attacked):
    arena = attacked(name, allowed)
    runs = arena.runs()
    assert np.array_equal(arena.spent, np.bincount(runs.scenario, minlength=2))
    assert 0 < arena.spent.min() <= arena.spent.max() <= BUDGET
    for c in range(2):
        assert sorted(runs.query[runs.scenario == c]) == list(range(1, arena.spent[c] + 1))
    assert (runs.variants.vehicle != TARGET).all()
    for run in np.unique(runs.variants.row).tolist():
        mine = runs.variants.row == run
        scene, vehicle = int(runs.variants.scene[run]), runs.variants.vehicle[mine]
        assert (arena.violation(scene, vehicle, runs.variants.motion[mine]) & RULES[allowed]) == 0
        exchanged = runs.variants.motion[mine]
        before = ground.traffic[scene]
        np.testing.assert_allclose(exchanged.position[:, 0], before.position[vehicle, 0], atol=0.05)


@pytest.mark.parametrize("name", ADVERSARIES)
def test_the_same_seed_gives_the_same_runs_and_a_case_is_the_run_it_came_from(name, ground, attacked):
    first, second = attacked(name, "legal").runs(), attack(name, ground).runs()
    np.testing.assert_array_equal(first.variants.motion.position, second.variants.motion.position)
    np.testing.assert_array_equal(first.outcome.motion.position, second.outcome.motion.position)
    for run in np.flatnonzero(first.outcome.counted)[:2].tolist():
        case = first.case(run, "idm", name)
        assert (case.step, case.queries, case.legal) == (int(first.outcome.step[run]), int(first.query[run]), True)


def test_two_attackers_drive_at_once_and_keep_the_rules_together(ground):
    arena = attack("drivegen_cs_two", ground, budget=12)
    variants = arena.runs().variants
    attackers = np.bincount(variants.row, minlength=len(variants))
    assert set(attackers) == {0, 1, 2}  # the scene as it is, one attacker, two
    for run in np.flatnonzero(attackers == 2).tolist():
        mine = variants.row == run
        vehicle, motion = variants.vehicle[mine], variants.motion[mine]
        assert len(set(vehicle.tolist())) == 2
        assert arena.violation(int(variants.scene[run]), vehicle, motion) == 0
        assert variants.attacker[run] in vehicle
