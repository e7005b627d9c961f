"""Testers of mutated drivers: who fails in traffic as it is, and what a search spends and finds."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.adversaries.shared.testers import by_search, by_traffic
from drivegen.core import plugins
from drivegen.core.settings import read_section
from drivegen.corner_cases.failures import alike, failures
from drivegen.corner_cases.trials import Variants
from drivegen.drivers.mutants.table import Mutant, mutated
from drivegen.metrics.mutation_score import Settings, scored
from drivegen.metrics.paired import chance
from drivegen.rollout.choices import choose
from drivegen.selectors.random import Plugin as Random
from drivegen.simulators.batch import Plugin as Batch
from tests.adversaries.test_adversaries_contract import attack, ground  # noqa: F401  # a fixture
from tests.checking import LIMITS
from tests.drivers.test_drivers_mutants import SCENES, SOUND, STANDS, behind
from tests.models import ROOT, candidate_settings
from tests.scenes import busy_crossing

MUTANTS = mutated({"idm": SOUND})
BUDGET = 3
SETTINGS = read_section("attack.adversaries", ROOT / "params.yaml")


@pytest.fixture(scope="module")
def in_traffic():
    scenes = [SCENES["ignores_standing"], SCENES["ignores_merging"], behind(STANDS, 14.0)]
    return by_traffic(MUTANTS, scenes, [scene.log for scene in scenes], [0, 0, 1])


def test_who_ignores_the_standing_runs_into_them_and_the_sound_one_does_not(in_traffic):
    pairs = in_traffic["idm.ignores_standing"]
    assert pairs.mutant.tolist() == ["standing", "", "standing"]
    assert pairs.sound.tolist() == ["", "", ""]
    assert (pairs.excess.tolist(), pairs.turn.tolist()) == ([1, 0, 1], [0, 0, 1])


@pytest.mark.parametrize(
    "name", [name for name, mutant in MUTANTS.items() if name.split(".")[1] in ("mirrored", "double", "doubled")]
)
def test_an_equivalent_one_has_no_excess(name, in_traffic):
    assert not in_traffic[name].excess.any()


def test_runs_are_alike_to_the_bit_or_not_at_all():
    scenes = [SCENES["ignores_standing"], busy_crossing()]
    traffic = [scene.log for scene in scenes]
    names = ("idm.ignores_standing", "idm.doubled")
    sound, standing, doubled = Batch().run_each([SOUND, *(MUTANTS[name] for name in names)], scenes, traffic)
    assert alike(sound, standing).tolist()[0] is False
    assert alike(sound, doubled).all()
    assert alike(sound, sound).all()


@pytest.mark.parametrize("name", ["random", "drivegen_cs", "advsim"])
def test_a_search_spends_as_many_runs_on_the_mutant_as_on_the_sound_one(name, ground):  # noqa: F811
    adversary = plugins.make("adversaries", name, SETTINGS, "here")
    some = {key: MUTANTS[key] for key in ("idm.ignores_merging", "idm.doubled")}
    found = dict(by_search(some, adversary, ground, Bounds("physical", BUDGET, 20), 7))
    for key, mutant in some.items():
        for driver, side in ((mutant, "mutant"), (SOUND, "sound")):
            alone = Arena(driver, ground, Bounds("physical", BUDGET, 20), 7)
            adversary.attack(alone)
            runs = alone.runs()
            counts = dict(zip(*np.unique(found[key].scenario, return_counts=True), strict=True))
            assert counts == {f"crossing-{c}": n for c, n in enumerate(alone.spent.tolist())}  # what is shared changes nothing
            failed = failures(runs.outcome, partial(runs.case, driver="", method=""))
            assert getattr(found[key], side).tolist() == failed[np.lexsort((runs.query, runs.scenario))].tolist()
    assert not found["idm.doubled"].excess.any()
    assert chance(found["idm.doubled"].excess) == 1.0


def test_who_of_two_is_the_tested_one_makes_no_difference(ground):  # noqa: F811
    adversary, bounds = plugins.make("adversaries", "drivegen_cs", SETTINGS, "here"), Bounds("legal", 10, 20)
    mutant = MUTANTS["idm.ignores_standing"]
    swapped = SimpleNamespace(name=SOUND.name, sees_rules=SOUND.sees_rules, act=SOUND.act, sound=mutant)
    one, back = (dict(by_search({"a": driver}, adversary, ground, bounds, 7))["a"] for driver in (mutant, swapped))
    assert one.excess.any()
    assert back.excess.tolist() == (-one.excess).tolist()


class Again:
    """An adversary that drives every scene once, and from then on that of each scenario in which the driver collided."""

    def attack(self, arena):
        of, steps = arena.ground.of, arena.trials.steps
        weak = np.flatnonzero(arena.drive(Variants.unchanged(np.arange(len(of)), steps)).collided)
        arena.drive(Variants.unchanged(np.repeat(weak, arena.left[of[weak]]), steps))


def left_and_right():
    """Six recordings, each with a scene in which somebody stands on the left and one in which somebody does on the right."""
    both = [SCENES["blind_left"], SCENES["blind_right"]]
    choices = choose([replace(both[0], scenario_id=f"run{n}-0") for n in range(6)], Random(), candidate_settings(), 1.0)
    return Ground(choices, np.repeat(np.arange(6), 2), [scene.log for scene in both] * 6, None, LIMITS)


@pytest.mark.parametrize(("tested", "beside"), [("blind_left", "blind_right"), ("blind_right", "blind_left")])
def test_who_fails_as_often_as_the_sound_one_but_elsewhere_is_not_killed(tested, beside):
    driver, sound = (Mutant(f"sac.{name}", SOUND) for name in (tested, beside))
    other = SimpleNamespace(name=tested, sees_rules=driver.sees_rules, act=driver.act, sound=sound)
    pairs = dict(by_search({tested: other}, Again(), left_and_right(), Bounds("physical", 10, 20), 7))
    assert [int((side != "").sum()) for side in (pairs[tested].mutant, pairs[tested].sound)] == [6 * 9, 6 * 9]
    score = scored(pairs, {tested: ()}, Settings(0.05, (20,), 2), np.random.default_rng(7))
    assert (score["equivalent"], score["false_kills"], score["drivers"][tested]["p"]) == (1, 0.0, 1.0)


def test_the_last_runs_of_a_scenario_are_left_out_where_one_of_the_two_has_more_of_them():
    mutants = {"sac.blind_left": Mutant("sac.blind_left", SOUND)}  # ten runs of it, two of the sound one, who never collides
    pairs = dict(by_search(mutants, Again(), left_and_right(), Bounds("physical", 10, 20), 7))["sac.blind_left"]
    assert pairs.scenario.tolist() == [f"run{n}-0" for n in range(6) for _ in range(2)]
    assert pairs.excess.tolist() == [1, 0] * 6


def test_an_arena_for_another_driver_has_made_no_run_and_finds_the_same(ground):  # noqa: F811
    first = attack("random", ground, "physical", BUDGET)
    other = first.again(first.trials.driver)
    assert other.spent.sum() == 0
    plugins.make("adversaries", "random", {"random": {}}, "here").attack(other)
    np.testing.assert_array_equal(first.runs().variants.motion.position, other.runs().variants.motion.position)
    np.testing.assert_array_equal(first.runs().outcome.motion.position, other.runs().outcome.motion.position)
