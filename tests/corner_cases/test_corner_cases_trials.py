"""Trials against the simulator that is handed whole traffic: the same runs to the bit, rules ahead included."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import Trajectories
from drivegen.corner_cases.trials import Trials, Variants
from drivegen.drivers import idm
from drivegen.simulators.batch import Plugin
from drivegen.world.reactive import Reaction
from tests.checking import IDM
from tests.scenes import busy_crossing, crossing, drive, joined, scenario, stack

REACTION = Reaction(delay=0.75, braking=6.0, headway=0.6, min_gap=1.0, acceleration=1.5, comfort=3.0)


def yielding():
    """The target comes from the left of somebody who has right of way."""
    roads = crossing(control=LaneControl.YIELD)
    return scenario(
        roads, stack([drive(joined(roads, 0, 9, 5), 40, 9, 101), drive(joined(roads, 2, 14, 6), 30, 8, 101)]), "yield-0"
    )


def with_track(motion, vehicle, track):
    arrays = {name: getattr(motion, name).copy() for name in ("position", "heading", "velocity", "valid")}
    for name, array in arrays.items():
        array[vehicle] = getattr(track, name)
    return Trajectories(**arrays)


@pytest.mark.parametrize("reaction", [None, REACTION])
@pytest.mark.parametrize("heeds", [False, True])
def test_an_exchanged_track_is_driven_as_if_it_had_been_there_from_the_beginning(heeds, reaction):
    scenes = [busy_crossing(scenario_id="busy-0"), yielding()]
    driver = idm.Plugin(replace(IDM, heeds_rules=heeds))
    ways = [(joined(scenes[0].map, 1, 11, 5), 4), (joined(scenes[1].map, 2, 14, 6), 1)]
    speeds = np.linspace(2, 12, 12)
    rows = [(s, ways[s][1], drive(ways[s][0], 30, float(v), 101)) for v in speeds for s in (0, 1)]
    variants = Variants.one_each(np.array([r[0] for r in rows]), np.array([r[1] for r in rows]), stack([r[2] for r in rows]))
    trials = Trials(driver, scenes, [s.log for s in scenes], reaction)
    quick = trials.run(variants)
    whole = [with_track(scenes[s].log, vehicle, track) for s, vehicle, track in rows]
    slow = Plugin(reaction=reaction).run(driver, [scenes[r[0]] for r in rows], whole, attacker=variants.attacker)
    for name in ("kind", "step", "partner", "at_fault", "impact_speed", "imposed_loss"):
        np.testing.assert_array_equal(getattr(quick, name), getattr(slow, name))
    np.testing.assert_array_equal(quick.motion.position, slow.motion.position)
    assert reaction is not None or 0 < quick.counted.sum() < len(rows)


def test_several_tracks_of_one_variant_and_none_of_another():
    scene = busy_crossing()
    driver = idm.Plugin(IDM)
    trials = Trials(driver, [scene], [scene.log])
    slower = drive(joined(scene.map, 0, 8, 4), 20.5, 3, 101)
    two = Variants(np.zeros(2, np.int64), np.array([1, 0]), np.zeros(2, np.int64), np.array([1, 4]), stack([slower, slower]))
    found = trials.run(two)
    moved = with_track(with_track(scene.log, 1, slower), 4, slower)
    expected = Plugin().run(driver, [scene, scene], [moved, scene.log])
    np.testing.assert_array_equal(found.motion.position, expected.motion.position)
    assert len(trials.run(Variants.unchanged(np.zeros(0), 101)).kind) == 0
