"""The picture of a question hides neither vehicles nor signals, which is measured over many questions of drawn scenes.

`DRIVEGEN_FUZZ` makes it the 200 questions of the promise; otherwise there are fewer.
"""

import os

import cv2
import numpy as np
import pytest

from drivegen.core.signals import Signals
from drivegen.goals.candidates import candidates
from drivegen.questions.goals import Case
from drivegen.questions.places import with_stops
from drivegen.questions.wordings import likeliest
from drivegen.render.goal_picture import ASKED, draw_goal_picture
from drivegen.render.goal_window import Reach
from drivegen.roads.graph import LaneGraph
from tests import scenes
from tests.models import candidate_settings
from tests.render.cover import covers, filled, hidden

QUESTIONS = 200 if "DRIVEGEN_FUZZ" in os.environ else 36
MOST_HIDDEN = 0.02
"""Share of the pixels of vehicles and signals."""

WORDING = likeliest("goals-2")


def crossing(random):
    """Queues and traffic on all arms of a crossing whose signals show anything."""
    roads = scenes.crossing(arm=float(random.uniform(60, 120)))
    log = []
    for arm in range(4):
        line, s = scenes.joined(roads, arm, 8 + 3 * arm, 4 + arm), 4.0
        for _ in range(int(random.integers(1, 6))):
            log.append(scenes.drive(line, s, float(random.choice([0.0, 0.0, 1.0, 5.0, 12.0])), 101))
            s += float(random.uniform(7, 25))
    lanes = np.arange(8, 20, dtype=np.int32)
    state = np.repeat(random.integers(0, 4, (12, 1)), 101, axis=1).astype(np.uint8)
    return scenes.scenario(roads, scenes.stack(log), "crossing", Signals(lanes, state))


def motorway(random):
    """Three lanes, jammed or fast."""
    roads = scenes.straight_road(900, 3)
    pace = float(random.choice([1.0, 8.0, 25.0, 34.0]))
    log = []
    for lane in range(3):
        s = float(random.uniform(200, 230))
        for _ in range(5):
            log.append(scenes.drive(scenes.joined(roads, lane), s, pace + float(random.uniform(0, 3)), 101))
            s += float(random.uniform(6, 8 + 2 * pace))
    return scenes.scenario(roads, scenes.stack(log), "motorway")


def cases(count):
    """So many questions, four of each scene at most."""
    random, settings, made = np.random.default_rng(7), candidate_settings(), []
    while len(made) < count:
        scene = (crossing, motorway)[len(made) // 4 % 2](random)
        graph = LaneGraph.of(scene.map)
        for n in random.choice(len(scene.vehicles), min(4, len(scene.vehicles), count - len(made)), replace=False).tolist():
            c = with_stops(scene, n, candidates(graph, scene, n, settings))
            made.append(Case.of(scene, n, c, 7, WORDING))
    return made


def test_marks_hide_next_to_nothing_of_vehicles_and_signals():
    found = np.array([covers(case) for case in cases(QUESTIONS)])  # questions, (vehicles, signals, lines), (hidden, all)
    whole = found.sum(0)
    assert len(found) == QUESTIONS
    assert (whole[:, 1] > 1000).all()
    assert (whole[:, 0] <= MOST_HIDDEN * whole[:, 1]).all()
    each = found[:, :2].sum(1)
    assert (each[:, 0] <= 5 * MOST_HIDDEN * each[:, 1]).all()


def test_the_measure_can_fail():
    [case] = cases(1)
    v = case.scenario.vehicles
    bare, _ = draw_goal_picture(case.scenario, case.vehicle, np.zeros((0, 2)), {}, Reach.of(np.zeros((1, 2))))
    middle = np.argwhere((bare == ASKED).all(-1)).mean(0)[::-1]
    corners = middle + np.array([[-4, -8], [4, -8], [4, 8], [-4, 8]])
    covered = bare.copy()
    cv2.circle(covered, np.rint(middle).astype(int).tolist(), 11, (25, 25, 30), cv2.FILLED)
    wrong, pixels = hidden(bare, covered, filled(bare.shape[:2], [corners]))
    assert wrong > 0.9 * pixels > 0
    assert len(v) > 1


def test_discs_are_numbered_at_their_places_and_the_picture_is_deterministic():
    for case in cases(4):
        scene, n = case.scenario, case.vehicle
        place = case.candidates.position[case.order]
        reach = Reach(400.0, 100.0, 100.0, 100.0)
        one, marks = draw_goal_picture(scene, n, place, {}, reach)
        two, _ = draw_goal_picture(scene, n, place, {}, reach)
        assert np.array_equal(one, two)
        gap = np.hypot(*(marks.disc[:, None] - marks.disc).transpose(2, 0, 1)) + 99 * np.eye(len(place))
        assert gap.min() > 22  # discs of 11 px do not touch
        assert (marks.disc > 10).all()
        assert (marks.disc < np.array(one.shape[1::-1]) - 10).all()
        assert np.array_equal(one[tuple(np.rint(marks.disc[0] + (0, 8)).astype(int)[::-1])], [25, 25, 30])


@pytest.mark.parametrize("ends", [(10.0, 0.0), (180.0, 20.0), (430.0, -60.0), (-130.0, 0.0), (0.0, 190.0)])
def test_the_window_grows_in_steps_to_where_places_are_and_is_never_less_than_the_papers(ends):
    reach = Reach.of(np.array([ends]))
    assert reach.holds(np.array([ends])).all()
    sides = np.array([reach.forward, reach.back, reach.left, reach.right])
    assert (sides >= 100).all()
    assert (sides % 50 == 0).all()
    assert sides.max() <= max(100, np.abs(ends).max() + 65)
