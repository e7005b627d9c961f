"""Goals to leave by: what is shown of a goal beyond an exit lies on the road, with the time at which the vehicle is there."""

import numpy as np
import pytest

from drivegen.core.scenario import DT
from drivegen.goals.candidates import candidates
from drivegen.goals.departures import STAYS_ON, departures
from drivegen.goals.outlook import STRIDE, Outlooks
from drivegen.roads.graph import LaneGraph
from drivegen.roads.leaving import Exits
from tests import scenes
from tests.goals.test_goals_candidates import SETTINGS, alone

START, SPEED = 40.0, 14.0


def shown(whole: bool):
    roads = scenes.straight_road(100, 1, whole)
    scene = alone(roads, scenes.joined(roads, 0), START, SPEED)
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    return scene, found, departures(scene, 0, found, Exits.of(roads))


def test_a_goal_beyond_the_end_of_the_network_is_shown_at_the_end_with_a_time():
    scene, found, out = shown(whole=True)
    half = scene.vehicles.size[0, 0] / 2
    beyond = found.position[:, 0] + half > 100 + 1e-3
    assert beyond.any()
    np.testing.assert_array_equal(out.leaves, beyond)
    np.testing.assert_allclose(out.place[beyond], np.tile([100 - half, 0], (beyond.sum(), 1)), atol=0.1)
    np.testing.assert_allclose(out.way[beyond], 100 - half - START, atol=0.1)
    assert (out.after[beyond] > 2).all()
    assert (out.after[beyond] <= 10).all()
    farthest = int(np.argmax(found.s))  # who gets farther is earlier at the exit
    assert out.after[farthest] == out.after.min()
    for name, value in (("position", out.place), ("s", out.way), ("speed", out.speed)):
        np.testing.assert_array_equal(value[~beyond], getattr(found, name)[~beyond])
    assert (out.after[~beyond] == STAYS_ON).all()


def test_the_time_is_that_of_the_outlook_which_is_in_nobody_s_way_from_then_on():
    scene, found, out = shown(whole=True)
    outlooks = Outlooks.of(scene, [found], np.array([scene.steps]))
    last = (outlooks.valid.sum(axis=1)[out.leaves] - 1) * STRIDE * DT
    assert outlooks.valid[~out.leaves].all()
    assert (last - 0.01 <= out.after[out.leaves]).all()
    assert (out.after[out.leaves] <= last + STRIDE * DT + 0.01).all()


def test_who_does_not_get_to_the_end_of_its_lane_stays_though_the_lane_comes_back_beside_it():
    bend = [(300 + 25 * np.sin(a), 25 - 25 * np.cos(a)) for a in np.linspace(0.2, np.pi - 0.2, 9)]
    hairpin = np.array([*((x, 0.0) for x in range(0, 301, 10)), *bend, *((x, 50.0) for x in range(300, 29, -10))], np.float64)
    roads = scenes.road_map([hairpin], links=[], neighbours=[], whole=True)
    for start, leaves in ((40.0, False), (hairpin_length(hairpin) - 30, True)):
        scene = alone(roads, scenes.joined(roads, 0), start, SPEED)
        found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
        out = departures(scene, 0, found, Exits.of(roads))
        assert out.leaves.any() == leaves
        assert (out.after[out.leaves] > 1).all()


def hairpin_length(line):
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def test_where_the_map_is_cut_goals_lie_beyond_it():
    _, found, out = shown(whole=False)
    assert not out.leaves.any()
    np.testing.assert_array_equal(out.place, found.position)
    assert found.leaves_map.any()


@pytest.mark.parametrize("whole", [False, True])
def test_ranking_and_planning_go_by_the_same_places_wherever_the_road_ends(whole):
    _, found, _ = shown(whole)
    _, other, _ = shown(not whole)
    np.testing.assert_array_equal(found.position, other.position)
    np.testing.assert_array_equal(found.prior, other.prior)
