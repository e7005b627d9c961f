"""Goals moved along, across and in speed, on their routes; what has no route stays."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.planners.base import PlanRequests
from drivegen.planners.shared.requests import moved
from drivegen.rollout.batch import goal_requests
from drivegen.rollout.choices import choose
from drivegen.selectors.random import Plugin as Random
from tests.models import candidate_settings, two_lanes


@pytest.fixture(scope="module")
def requests() -> PlanRequests:
    """All goals of the first vehicle of a straight road, which leads to the right."""
    [choice] = choose([two_lanes()], Random(), candidate_settings(), 1.0)
    rows = np.array([(0, 0, c, 0) for c in range(len(choice.candidates[0]))])
    return goal_requests([choice], [rows], lambda _: 7)


def by(requests: PlanRequests, along: float, across: float, speed: float) -> PlanRequests:
    return moved(requests, *(np.full(len(requests), value) for value in (along, across, speed)))


def test_nothing_changes_where_nothing_is_moved(requests):
    same = by(requests, 0.0, 0.0, 0.0)
    for name in ("goal_position", "goal_s", "goal_d", "goal_speed"):
        np.testing.assert_allclose(getattr(same, name), getattr(requests, name), atol=0.02)
    routed = requests.route >= 0
    assert routed.any()
    assert np.abs(same.goal_heading - requests.goal_heading)[routed].max() < 0.05


def test_a_goal_moves_along_and_across_its_route(requests):
    inner = (requests.route >= 0) & (requests.goal_s > 10) & (requests.goal_s < requests.route_length[requests.route] - 10)
    assert inner.any()
    shift = (by(requests, 6.0, 0.5, 2.0).goal_position - requests.goal_position)[inner]
    np.testing.assert_allclose(shift, np.tile([6.0, 0.5], (inner.sum(), 1)), atol=0.02)
    np.testing.assert_allclose(by(requests, 6.0, 0.5, 2.0).goal_speed[inner], requests.goal_speed[inner] + 2, atol=1e-5)


def test_it_stays_on_its_route_and_stands_at_least(requests):
    back, far = by(requests, -1e4, 0.0, -100.0), by(requests, 1e4, 0.0, 0.0)
    on = requests.route >= 0
    assert (back.goal_s[on] == 0).all()
    assert (back.goal_speed[on] == 0).all()
    assert (far.goal_s[on] <= requests.route_length[requests.route][on]).all()


def test_who_has_no_route_keeps_the_goal(requests):
    nowhere = replace(requests, route=np.full(len(requests), -1, np.int32))
    assert by(nowhere, 5.0, 1.0, 1.0) is nowhere
    some = replace(requests, route=np.where(np.arange(len(requests)) == 0, -1, requests.route).astype(np.int32))
    np.testing.assert_array_equal(by(some, 5.0, 1.0, 1.0).goal_position[0], requests.goal_position[0])
