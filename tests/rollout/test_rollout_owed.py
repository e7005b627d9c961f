"""What vehicles owe to others: the way, the target's rear, room to stop; and who was seen once."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.roadmap import LaneControl
from drivegen.core.samples import Samples, Violation
from drivegen.goals.candidates import candidates
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.roads.graph import LaneGraph
from drivegen.rollout.batch import BRAKING, goal_requests, roll_out
from drivegen.rollout.choices import Choices, choose, tempered
from drivegen.rollout.models import Equipment
from drivegen.rollout.scene import RolloutSettings
from drivegen.selectors.log import Plugin as LogSelector
from tests.checking import LIMITS
from tests.models import candidate_settings
from tests.scenes import crossing, drive, joined, scenario, stack, straight_road

ROAD = straight_road(300)
LINE = ROAD.centreline[0].astype(np.float64)
SETTINGS = RolloutSettings(attempts=4, rounds=5, evictions=2, drop_illegal=False, target_steps=None, exclusion=True, tempo=0.8)


@pytest.fixture(scope="module")
def equipment(models) -> Equipment:
    return Equipment.open(models, "route_fm", "random")


@pytest.mark.parametrize("target_steps", [20, None])
def test_who_rams_the_target_from_behind_is_illegal_whether_or_not_its_driver_reacts(equipment, target_steps):
    log = stack([drive(LINE, 60, 10, 101, -2.5), drive(LINE, 40, 10, 101)])
    scene = scenario(ROAD, log)
    found = [candidates(LaneGraph.of(ROAD), scene, n, candidate_settings()) for n in range(2)]
    far = int(np.argmin(np.abs(found[1].s - 100)))  # the follower is pressed to drive on through the one that brakes
    odds = [found[0].prior, np.eye(len(found[1]), dtype=np.float32)[far]]
    settings = replace(SETTINGS, target_steps=target_steps)
    (rolled,) = roll_out([Choices(scene, found, odds, odds)], equipment.planner, LIMITS, settings, 2, 7, "corner", [log[[0, 0]]])
    assert (rolled.violation[:, 1] & Violation.COLLISION).all()
    assert (rolled.first_violation[:, 1] > 20).all()


def test_who_owes_the_way_to_one_that_was_planned_later_is_planned_again(equipment):
    rolled = futures_at_a_crossing(equipment, replace(SETTINGS, rounds=10))
    assert not any((samples.violation & Violation.STOP_OR_YIELD).any() for samples in rolled)
    once = futures_at_a_crossing(equipment, replace(SETTINGS, rounds=1))
    assert any((samples.violation & Violation.STOP_OR_YIELD).any() for samples in once)


def futures_at_a_crossing(equipment: Equipment, settings: RolloutSettings) -> list[Samples]:
    """Ten futures of 30 scenes of four cars in any order, of whom two come over arms that give way."""
    roads = crossing(arm=110, control=LaneControl.FREE, whole=True)
    control = roads.control.copy()
    for arm in (1, 3):
        control[8 + 3 * arm : 11 + 3 * arm] = LaneControl.YIELD
    roads = replace(roads, control=control)
    graph, rng, choices = LaneGraph.of(roads), np.random.default_rng(1), []
    for i in range(30):
        starts = [(arm, rng.uniform(20, 80), rng.uniform(6, 12)) for arm in rng.permutation(4).tolist()]
        log = stack([drive(joined(roads, arm, 8 + 3 * arm, 4 + arm), at, speed, 101) for arm, at, speed in starts])
        scene = scenario(roads, log, f"scene-{i}")
        found = [candidates(graph, scene, n, candidate_settings()) for n in range(4)]
        odds = [c.prior for c in found]
        choices.append(Choices(scene, found, odds, tempered(odds, found, 0.45)))
    return roll_out(choices, equipment.planner, LIMITS, settings, 10, 7, "drivegen")


@pytest.mark.parametrize(("speed", "may_stay"), [(1.9, True), (6.0, False)])
def test_beside_all_lanes_nobody_stands_at_once(equipment, speed, may_stay):
    off = np.array([[100.0, 30.0], [100.0, 80.0]])
    scene = scenario(ROAD, stack([drive(off, 0, speed, 101)]))
    found = candidates(LaneGraph.of(ROAD), scene, 0, candidate_settings())
    (stays,) = np.nonzero(found.manoeuvre == Manoeuvre.STAY)
    assert (len(stays) > 0) is may_stay
    if may_stay:
        choice = Choices(scene, [found], [found.prior], [found.prior])
        requests = goal_requests([choice], [np.array([[0, 0, stays[0], 0]])], lambda _: 7)
        assert requests.goal_position[0] == pytest.approx([100.0, 30.0 + speed**2 / (2 * BRAKING)], abs=1e-3)


@pytest.mark.parametrize("seen", [1, 2])
def test_the_true_goal_of_who_was_seen_for_a_moment_can_be_planned(equipment, seen):
    log = stack([drive(LINE, 120, 8, 101), drive(LINE, 20.0, 10, 101)])
    log.valid[1, seen:] = False
    choices = choose([scenario(ROAD, log)], LogSelector(), candidate_settings(), 1.0)
    (rolled,) = roll_out(choices, equipment.planner, LIMITS, SETTINGS, 1, 7, "drivegen_true_goals")
    assert np.abs(np.diff(rolled.motion.speed[0, 1, :2])).max() < 1.0
