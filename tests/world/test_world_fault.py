"""nuPlan's classes of collisions, and how fast the two meet."""

import numpy as np
import pytest

from drivegen.simulators.batch import Plugin
from drivegen.world.fault import Contact, contact_of, within_lane
from drivegen.world.scenes import Scenes
from tests.scenes import LANE_WIDTH, across, drive, scenario, stack, straight_road
from tests.world.steady import Steady

ROAD = straight_road(600)
LINE = ROAD.centreline[0].astype(np.float64)
NEXT = ROAD.centreline[1].astype(np.float64)


@pytest.mark.parametrize(
    ("contact", "at_fault", "speed", "other", "own", "offset"),
    [
        (Contact.STOPPED_TRACK, True, 10, drive(LINE, 80, 0, 101), 10, None),
        (Contact.ACTIVE_FRONT, True, 6, drive(LINE, 80, 4, 101), 10, None),
        (Contact.ACTIVE_FRONT, True, 18, drive(LINE[::-1].copy(), 480, 8, 101), 10, None),
        (Contact.ACTIVE_REAR, False, 6, drive(LINE, 20, 16, 101), 10, None),
        (Contact.STOPPED_EGO, False, 16, drive(LINE, 20, 16, 101), 0, None),
        (Contact.ACTIVE_LATERAL, True, 2.9, drive(NEXT, 47, 10, 101), 10, LANE_WIDTH),
        (Contact.ACTIVE_LATERAL, False, np.hypot(10, 12), drive(across(80), 80, 12, 101), 10, None),
        (Contact.NONE, False, np.nan, drive(NEXT, 50, 10, 101), 10, None),
    ],
)
def test_whose_fault_it_is(contact, at_fault, speed, other, own, offset):
    log = stack([drive(LINE, 50, own, 101), other])
    outcome = Plugin().run(Steady(offset), [scenario(ROAD, log)], [log])
    assert (Contact(outcome.contact[0]), bool(outcome.at_fault[0])) == (contact, at_fault)
    assert outcome.impact_speed[0] == pytest.approx(speed, abs=0.6, nan_ok=True)
    assert outcome.imposed_braking[0] == 0


@pytest.mark.parametrize(
    ("contact", "own", "theirs", "gap"),
    [
        (Contact.STOPPED_EGO, 0.05, 10.0, (4.0, 0.0)),
        (Contact.STOPPED_TRACK, 0.06, 0.05, (4.0, 0.0)),
        (Contact.ACTIVE_FRONT, 0.06, 0.06, (4.0, 0.0)),
        # 150 degrees from the heading, seen from the rear axle, which is 0.28 * 4.6 m = 1.288 m behind the centre
        (Contact.ACTIVE_REAR, 10.0, 5.0, (-1.288 - 1.8, 1.0)),
        (Contact.ACTIVE_LATERAL, 10.0, 5.0, (-1.288 - 1.6, 1.0)),
    ],
)
def test_nuplan_s_thresholds_are_kept(contact, own, theirs, gap):
    log = stack([drive(LINE, 50, own, 11), drive(LINE + np.array([0.0, gap[1]]), 50 + gap[0], theirs, 11)])
    scene = scenario(ROAD, log)
    others = Scenes.of([scene], [log]).replay
    assert contact_of(log[0], scene.vehicles.size[0, :2], others, 0, 0, 0) == contact


@pytest.mark.parametrize(("y", "inside"), [(0.0, True), (1.75, False), (3.5, True), (-4.0, False)])
def test_a_box_is_within_a_lane_or_in_several_or_off_the_road(y, inside):
    corners = np.array([(102.3, y + 0.95), (97.7, y + 0.95), (97.7, y - 0.95), (102.3, y - 0.95)])
    assert within_lane(ROAD, corners) == inside
