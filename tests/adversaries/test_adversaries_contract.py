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
from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import TARGET
from drivegen.core.settings import build, read_section
from drivegen.drivers import idm
from drivegen.rollout.choices import choose
from drivegen.selectors.random import Plugin as Random
from tests.checking import IDM, LIMITS
from tests.models import ROOT, candidate_settings, planner
from tests.scenes import busy_crossing, drive, joined, scenario, stack, straight_road

ADVERSARIES = plugins.names("adversaries")
BUDGET = 4


@pytest.fixture(scope="module")
def ground():
    """Two scenes of one scenario, and one of a shorter scenario."""
    scenes = [busy_crossing(steps, f"crossing-{i}") for i, steps in enumerate((101, 91))]
    choices = choose(scenes, Random(), candidate_settings(), 1.0)
    traffic = [lawful(scenes[s]) for s in (0, 0, 1)]
    return Ground(choices, np.array([0, 0, 1]), traffic, planner([scenes[0], busy_crossing(101, "crossing-2")]), LIMITS)


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


@pytest.mark.parametrize("name", ["untouched", "dataset"])
def test_traffic_as_it_is_is_driven_as_often_as_the_budget_allows(name, ground):
    runs = attack(name, ground, budget=1).runs()
    assert runs.variants.scene.tolist() == [0, 2]


def test_where_there_is_no_traffic_nobody_attacks(ground):
    with pytest.raises(UnusableInput, match="there is no traffic to attack the driver in"):
        Arena(idm.Plugin(IDM), replace(ground, choices=[], of=np.zeros(0, np.int64), traffic=[]), Bounds("legal", 4, 20), 7)


def test_of_two_attackers_each_is_judged_beside_the_other_as_it_drives_now(ground):
    road = straight_road(600, 2)
    own, beside = (joined(road, lane) for lane in (1, 0))
    log = stack([drive(own, 300, 10, 101), drive(beside, 60, 5, 101), drive(beside, 40, 5, 101)])
    choices = choose([scenario(road, log)], Random(), candidate_settings(), 1.0)
    arena = Arena(
        idm.Plugin(IDM), replace(ground, choices=choices, of=np.zeros(1, np.int64), traffic=[log]), Bounds("legal", 4, 20), 7
    )
    faster = stack([drive(beside, 60, 12, 101), drive(beside, 40, 10, 101)])
    assert arena.violation(0, np.array([2]), faster[[1]]) & Violation.COLLISION  # by itself it runs into who drives on as before
    assert arena.violation(0, np.array([1, 2]), faster) == 0


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
