"""Ends of tracks as labels, also of those that left early."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.goals.candidates import candidates
from drivegen.goals.labels import LEAST_SEEN, UNSTEADY, ends
from drivegen.roads.graph import LaneGraph
from tests import scenes
from tests.goals.test_goals_candidates import SETTINGS


def seen_until(step):
    """A car that turns left at a crossing at a steady speed, seen until `step`; and its end had it been seen."""
    roads = scenes.crossing()
    log = scenes.stack([scenes.drive(scenes.joined(roads, 0, 9, 5), 40, 9.0, 101)])
    end = log.position[0, -1].copy()
    valid = log.valid.copy()
    valid[0, step + 1 :] = False
    scene = scenes.scenario(roads, replace(log, valid=valid))
    return scene, [candidates(LaneGraph.of(roads), scene, 0, SETTINGS)], end


def test_a_seen_end_is_taken_as_it_is():
    scene, found, end = seen_until(100)
    label = ends(scene, found)
    assert label.position[0] == pytest.approx(end)
    assert label.doubt[0] == 0


def test_a_car_that_left_is_carried_on_round_the_bend():
    scene, found, end = seen_until(70)
    label = ends(scene, found)
    assert np.hypot(*(label.position[0] - end)) < 3.0
    assert label.doubt[0] == pytest.approx(UNSTEADY * 3.0**2 / 2)


def test_a_car_hardly_seen_is_no_label_and_neither_is_one_without_a_log():
    scene, found, _ = seen_until(int(100 * LEAST_SEEN) - 1)
    assert len(ends(scene, found).vehicle) == 0
    assert len(ends(replace(scene, log=None), found).vehicle) == 0


@pytest.mark.parametrize("step", [94, 95, 99])
def test_a_car_is_carried_on_whenever_it_left(step):
    scene, found, end = seen_until(step)
    assert np.hypot(*(ends(scene, found).position[0] - end)) < 1.0
