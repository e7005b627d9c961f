"""What the checker turns down during a rollout: noted with its reason if wanted, and never at the price of another scene."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.rejections import Rejected, Rejections
from drivegen.core.samples import Violation
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.goals.candidates import candidates
from drivegen.roads.graph import LaneGraph
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import Choices, choose
from drivegen.rollout.models import Equipment
from drivegen.rollout.scene import Rollout, RolloutSettings
from tests.checking import LIMITS
from tests.models import candidate_settings, two_lanes
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

SETTINGS = RolloutSettings(attempts=3, rounds=4, evictions=1, drop_illegal=False, target_steps=None, exclusion=True, tempo=0.8)
ROAD = straight_road()
LINE = ROAD.centreline[0].astype(np.float64)
FINE = drive(LINE, 10, 10, 101)
FAST = drive(LINE, 10, 20, 101)
ASIDE = replace(FAST, position=FAST.position + np.float32([[0, -3]]) * np.linspace(0, 1, 101, dtype=np.float32)[:, None])
"""Too fast, and off the road in the end."""
BOTH = Violation.SPEED | Violation.OFF_ROAD


def started(scene: Scenario, **changes) -> tuple[Rollout, Rejections]:
    """A rollout of one sample whose vehicles' goals do not matter: the test commits what it likes."""
    found = [candidates(LaneGraph.of(scene.map), scene, n, candidate_settings()) for n in range(len(scene.vehicles))]
    odds = [np.full(len(one), 1 / len(one), np.float32) for one in found]
    notes = Rejections()
    return Rollout(Choices(scene, found, odds, odds), LIMITS, replace(SETTINGS, **changes), 1, 7, None, notes), notes


def commit(rollout: Rollout, vehicle: int, *motions: Trajectories) -> None:
    rollout.commit(np.array([(0, vehicle, 0, a) for a in range(len(motions))]), stack(list(motions)))


def noted(rollout: Rollout, notes: Rejections) -> Rejected:
    return notes.replaced_in(rollout.result("drivegen"))


def test_each_has_the_rules_that_it_broke_and_what_came_after_the_legal_one_was_not_needed():
    rollout, notes = started(scenario(ROAD, stack([FINE])))
    commit(rollout, 0, ASIDE)
    commit(rollout, 0, FAST, FINE, ASIDE)
    found = noted(rollout, notes)
    assert found.violation.tolist() == [BOTH, Violation.SPEED]
    np.testing.assert_array_equal(found.position, [ASIDE.position, FAST.position])
    assert (found.sample.tolist(), found.vehicle.tolist(), found.made_way.any()) == ([0, 0], [0, 0], False)
    assert found.summary == "2 turned down: 2 speed, 1 off road"


def test_the_illegal_one_that_stays_was_not_replaced_but_what_is_dropped_was_turned_down():
    for drop, left in ((False, [BOTH]), (True, [Violation.SPEED, BOTH])):
        rollout, notes = started(scenario(ROAD, stack([FINE])), drop_illegal=drop)
        commit(rollout, 0, FAST, ASIDE)
        assert noted(rollout, notes).violation.tolist() == left


def test_the_illegal_one_that_stays_and_leaves_the_map_was_not_replaced():
    way_out = drive(LINE, 250, 20, 101)
    rollout, notes = started(scenario(straight_road(whole=True), stack([drive(LINE, 250, 10, 101)])))
    commit(rollout, 0, ASIDE, way_out)
    samples = rollout.result("drivegen")
    assert samples.left_map.all()
    assert samples.violation.tolist() == [[Violation.SPEED]]
    assert notes.replaced_in(samples).violation.tolist() == [BOTH]


def test_who_makes_way_is_noted_as_that():
    """The target drives over the place of a parked car, which cannot get out of its way."""
    parked = drive(LINE, 60, 0, 101)
    scene = scenario(ROAD, stack([FINE, parked]))
    rollout, notes = started(scene)
    commit(rollout, 0, FINE)
    commit(rollout, 1, parked)
    commit(rollout, 0, drive(LINE, 10, 10, 101, -2.0))
    found = noted(rollout, notes)
    assert (found.vehicle.tolist(), found.made_way.tolist()) == ([0], [True])
    assert found.violation.tolist() == [Violation.COLLISION]
    np.testing.assert_array_equal(found.position, [FINE.position])
    assert found.reasons == {"made way": 1}


def test_nothing_turned_down_is_said_and_has_the_scene_s_steps():
    rollout, notes = started(scenario(ROAD, stack([FINE])))
    commit(rollout, 0, FINE)
    found = noted(rollout, notes)
    assert found.position.shape == (0, 101, 2)
    assert found.summary == "none turned down"
    assert found.dashes(2.0).shape == (0, 2, 2)


def test_dashes_lie_on_the_way_with_gaps_between_them():
    rollout, notes = started(scenario(ROAD, stack([FINE])))
    commit(rollout, 0, FAST, FINE)
    dashes = noted(rollout, notes).dashes(2.0)  # 200 m at 20 m/s for ten seconds
    np.testing.assert_allclose(dashes[:, 0, 0], 10 + 6.0 * np.arange(34), atol=1e-3)
    np.testing.assert_allclose(dashes[:-1, 1, 0] - dashes[:-1, 0, 0], 2.0, atol=1e-3)
    np.testing.assert_allclose(dashes[..., 1], 0.0, atol=1e-6)


@pytest.fixture(scope="module")
def equipment(models) -> Equipment:
    return Equipment.open(models, "route_fm", "random")


@pytest.fixture(scope="module")
def choices(equipment) -> list[Choices]:
    return choose([busy_crossing(), two_lanes(9.0)], equipment.selector, candidate_settings(), 1.0)


def test_samples_are_the_same_whether_or_not_notes_are_taken_and_every_attempt_is_accounted_for(equipment, choices):
    notes = {choices[0].scenario.scenario_id: Rejections()}
    plain, watched = (
        roll_out(choices, equipment.planner, equipment.limits, SETTINGS, 4, 7, "drivegen", rejections=wanted)
        for wanted in (None, notes)
    )
    for one, other in zip(plain, watched, strict=True):
        for name in ("position", "heading", "velocity", "valid"):
            np.testing.assert_array_equal(getattr(one.motion, name), getattr(other.motion, name))
        for name in ("violation", "goal", "attempts", "natural"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    samples = watched[0]
    found = notes[samples.scenario_id].replaced_in(samples)
    counted = np.zeros(samples.attempts.shape, np.int64)
    np.add.at(counted, (found.sample, found.vehicle), 1)
    assert len(found) > 0
    np.testing.assert_array_equal(counted, samples.attempts - 1)
