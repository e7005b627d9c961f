"""Outlooks: where they lead, and which goals exclude each other."""

import numpy as np
import pytest

from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.goals.candidates import Candidates, candidates
from drivegen.goals.outlook import STRIDE, Outlooks
from drivegen.roads.graph import LaneGraph
from tests import scenes
from tests.goals.test_goals_candidates import SETTINGS


def offered(scene: Scenario) -> list[Candidates]:
    graph = LaneGraph.of(scene.map)
    return [candidates(graph, scene, n, SETTINGS) for n in range(len(scene.vehicles))]


def throughout(scene: Scenario) -> np.ndarray:
    """The target counts for everyone until the end."""
    return np.full(len(scene.vehicles), scene.steps)


def queue(gap: float = 30.0, speed: float = 8.0) -> Scenario:
    """The target behind a leader on a single lane."""
    roads = scenes.straight_road(400, 1)
    return scenes.scenario(roads, scenes.stack([scenes.drive(roads.centreline[0], 20 + gap * i, speed, 101) for i in range(2)]))


def test_outlooks_begin_in_the_initial_state_and_end_at_the_goal():
    for scene in (scenes.busy_crossing(), queue()):
        found = offered(scene)
        outlooks = Outlooks.of(scene, found, throughout(scene))
        assert outlooks.position.shape == (sum(map(len, found)), 1 + scene.horizon // STRIDE, 2)
        np.testing.assert_array_equal(outlooks.position[:, 0], scene.vehicles.position[outlooks.owner])
        goals = np.concatenate([c.position for c in found])
        np.testing.assert_allclose(outlooks.position[:, -1], goals, atol=0.05)


def test_expected_speeds_start_and_end_as_asked_and_never_drive_back():
    scene = queue()
    found = offered(scene)
    outlooks = Outlooks.of(scene, found, throughout(scene))
    moved = np.diff(outlooks.position[..., 0], axis=1)
    assert (moved > -1e-3).all()
    far = np.concatenate([c.s for c in found]) > 60
    np.testing.assert_allclose(moved[far, 0] / (STRIDE * DT), 8.0, atol=1.0)
    ends = np.concatenate([c.speed for c in found])
    np.testing.assert_allclose(moved[far, -1] / (STRIDE * DT), ends[far], atol=1.0)


def test_a_follower_cannot_end_beyond_its_leader():
    scene = queue()
    found = offered(scene)
    outlooks = Outlooks.of(scene, found, throughout(scene))
    follower, leader = (outlooks.position[outlooks.start[n] : outlooks.start[n + 1], -1, 0] for n in (0, 1))
    exclusive = outlooks.exclusions()[: outlooks.start[1], outlooks.start[1] :]
    beyond = follower[:, None] > leader[None] - 4.0
    behind = follower[:, None] < leader[None] - 15.0
    assert beyond.any()
    assert behind.any()
    assert exclusive[beyond].all()
    assert not exclusive[behind].any()


def test_exclusion_is_mutual_and_never_within_a_vehicle():
    outlooks = Outlooks.of(scenes.busy_crossing(), offered(scenes.busy_crossing()), throughout(scenes.busy_crossing()))
    exclusive = outlooks.exclusions()
    np.testing.assert_array_equal(exclusive, exclusive.T)
    assert not exclusive[outlooks.owner[:, None] == outlooks.owner[None]].any()
    assert exclusive.any()


def test_the_target_counts_for_its_first_steps_only_where_its_driver_is_to_react():
    scene = queue(gap=-30.0)  # the target leads
    always, briefly = (Outlooks.of(scene, offered(scene), np.array([101, steps])) for steps in (101, 8))
    assert always.exclusions().any()
    assert not briefly.exclusions().any()
    standing = scenes.stack([scenes.drive(scene.map.centreline[0], 90, 0.0, 101)] * 2)
    sizes = scene.vehicles.size[:, :2]
    assert always.meetings(1, standing, sizes).any()
    assert not briefly.meetings(1, standing, sizes).any()
    assert briefly.meetings(0, standing, sizes).any()  # the target itself avoids everyone


def test_meetings_count_committed_vehicles_but_not_the_asking_one():
    scene = queue()
    outlooks = Outlooks.of(scene, offered(scene), throughout(scene))
    sizes = scene.vehicles.size[:, :2]
    standing = scenes.stack([scenes.drive(scene.map.centreline[0], at, 0.0, 101) for at in (20, 60)])
    met = outlooks.meetings(0, standing, sizes)
    beyond = outlooks.position[: outlooks.start[1], -1, 0] > 60 - 4
    np.testing.assert_array_equal(met, beyond.astype(int))
    nobody = Trajectories.empty(2, 101)
    assert not outlooks.meetings(0, nobody, sizes).any()


def test_boxes_that_overlap_from_the_start_exclude_nothing_until_they_come_apart():
    scene = queue(gap=2.0)
    outlooks = Outlooks.of(scene, offered(scene), throughout(scene))
    same = [int(np.argmin(np.abs(outlooks.position[outlooks.owner == n, -1, 0] - 100))) for n in (0, 1)]
    assert not outlooks.exclusions()[same[0], outlooks.start[1] + same[1]]


@pytest.mark.parametrize("seed", range(4))
def test_outlooks_are_finite_on_any_scene(seed):
    scene = scenes.any_scenario(seed)
    outlooks = Outlooks.of(scene, offered(scene), throughout(scene))
    assert np.isfinite(outlooks.position).all()
    assert np.isfinite(outlooks.heading).all()
