"""Draws from the vehicles of training logs."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.placement.draws import Draws
from tests.placement.rows import joined_rows, queue_rows


def test_followers_and_leaders_are_like_the_speed_and_the_limit_asked_for():
    slow, fast = [queue_rows(f"slow-{n}", 8.0, 5.0) for n in range(20)], [queue_rows(f"fast-{n}", 40.0, 20.0) for n in range(20)]
    elsewhere = [queue_rows(f"elsewhere-{n}", 25.0, 5.0, limit=8.0) for n in range(20)]
    draws = Draws(joined_rows(*slow, *fast, *elsewhere))
    for found, gap in ((draws.followers(5.0, 20.0), 8), (draws.leaders(20.0, 20.0), 40), (draws.followers(5.0, 8.0), 25)):
        assert len(found) >= Draws.NEAREST
        assert found.gap == pytest.approx(gap, abs=0.1)
    assert draws.least_gap + 5.0 * draws.least_time_gap <= 8.1


def test_traffic_around_a_target_is_that_of_one_log_with_a_like_target():
    short = [queue_rows(f"short-{n}", 10.0, 3.0, cars=3) for n in range(10)]
    draws = Draws(joined_rows(*short, *(queue_rows(f"long-{n}", 30.0, 18.0, cars=9) for n in range(10))))
    random = np.random.default_rng(0)
    near, far = draws.around(3, 3.0, 20.0, random), draws.around(9, 18.0, 20.0, random)
    assert (near.reach, near.share_led) == (pytest.approx(2 * 14.6, abs=0.1), pytest.approx(2 / 3))
    assert (far.reach, far.share_led) == (pytest.approx(8 * 34.6, abs=0.1), pytest.approx(8 / 9))
    assert near.first.speed == pytest.approx(3.0)
    assert draws.farthest == pytest.approx(far.reach)
    assert {round(draws.target_speed(20.0, random)) for _ in range(40)} == {3, 18}


def test_offsets_are_those_of_logs_and_leave_a_vehicle_on_its_lane():
    gaps = joined_rows(*(queue_rows(f"log-{n}", 10.0, 5.0) for n in range(10)))
    offset = np.linspace(-1.5, 1.5, len(gaps)).astype(np.float32)
    inside = np.arange(len(gaps)) % 2 == 0
    draws = Draws(replace(gaps, offset=np.where(inside, 5.0, offset), to_junction=np.where(inside, 0.0, np.inf)))
    found = draws.offsets(np.repeat([0.3, 1.0, 9.0], 500), np.random.default_rng(0)).reshape(3, 500)
    assert (np.abs(found).max(axis=1) <= [0.3, 1.0, 1.5]).all()  # and nobody cuts the corner of a junction
    assert (found.min(axis=1) < [-0.2, -0.8, -1.3]).all()
    assert (found.max(axis=1) > [0.2, 0.8, 1.3]).all()
    assert not draws.offsets(np.array([0.0, -1.0]), np.random.default_rng(0)).any()
