"""Who is on the lanes of those who come, by its front corners."""

import numpy as np
import pytest

from drivegen.checker.limits import RULES
from drivegen.checker.scene import SceneChecker
from drivegen.core.samples import Violation
from tests.checking import LIMITS, two_way_road
from tests.scenes import LANE_WIDTH, beside, drive, road_map, scenario, stack, straight_road

LINE = straight_road().centreline[0].astype(np.float64)
STEPS, WIDTH = 101, 1.9


def oncoming(roads, motion):
    """Severity [s] of the rule, its first illegal step, and whether the trajectory is on the wrong way."""
    log = stack([motion])
    found = SceneChecker(scenario(roads, log), LIMITS).severities(log[np.newaxis])
    rule = RULES.index("oncoming_lanes")
    return float(found.worst[0, 0, rule]), int(found.first[0, 0, rule]), bool(found.violation[0, 0] & Violation.WRONG_WAY)


@pytest.mark.parametrize("hand", [1, -1])
@pytest.mark.parametrize(("over", "wrong"), [(-0.5, False), (0.2, False), (0.9, True), (1.5, True)])
def test_who_keeps_a_corner_over_the_centre_line_is_on_the_oncoming_lanes(hand: int, over: float, wrong: bool):
    """In right-hand traffic (1) those who come are to the left, in left-hand traffic (-1) to the right."""
    roads = road_map([LINE, beside(LINE[::-1].copy(), -hand * LANE_WIDTH)])
    across = LANE_WIDTH / 2 + over - WIDTH / 2
    late = drive(LINE, 20, 8, STEPS)
    late.position[50:, 1] += np.float32(hand * across)
    seconds, first, illegal = oncoming(roads, late)
    assert illegal is wrong
    assert seconds == (pytest.approx(5.1, abs=0.2) if wrong else 0)
    assert first == (pytest.approx(55, abs=2) if wrong else -1)


def test_a_line_between_lanes_of_one_way_may_be_driven_on_and_who_stands_over_the_centre_line_does_not_drive():
    along = drive(beside(LINE, LANE_WIDTH / 2), 20, 8, STEPS)
    assert oncoming(straight_road(300, 2), along) == (0, -1, False)
    still = drive(beside(LINE, LANE_WIDTH / 2), 20, 0.9, STEPS)
    assert oncoming(two_way_road(), still) == (0, -1, False)


def test_who_starts_over_the_centre_line_is_judged_once_it_has_left_it():
    over = drive(beside(LINE, LANE_WIDTH / 2), 20, 8, STEPS)
    assert oncoming(two_way_road(), over) == (0, -1, False)
    over.position[30:50, 1] -= np.float32(LANE_WIDTH / 2)
    seconds, first, illegal = oncoming(two_way_road(), over)
    assert illegal
    assert seconds == pytest.approx(5.1, abs=0.2)
    assert first == pytest.approx(55, abs=2)


@pytest.mark.parametrize("speed", [0.0, 0.9, 1.1])
def test_who_starts_over_the_centre_line_may_drive_on_from_standing(speed: float):
    over = drive(beside(LINE, LANE_WIDTH / 2), 20, speed, 61, 2.0)
    assert oncoming(two_way_road(), over) == (0, -1, False)
