"""Post-encroachment times: by hand and against plain loops."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.scenario import DT, Trajectories
from drivegen.metrics.encroachment import CROSSING, LONGEST, SAME_PLACE, post_encroachment
from tests.scenes import stack


def straight(start, heading, speed, steps=60, valid=None) -> Trajectories:
    direction = np.array([np.cos(heading), np.sin(heading)])
    position = np.asarray(start) + speed * DT * np.arange(steps)[:, None] * direction
    return Trajectories(
        position.astype(np.float32),
        np.full(steps, heading, np.float32),
        np.tile(np.float32(speed * direction), (steps, 1)),
        np.ones(steps, np.bool_) if valid is None else valid,
    )


def times(*vehicles) -> list[float]:
    motion = stack(list(vehicles))
    return post_encroachment(motion[np.newaxis], motion.valid[np.newaxis])[0].tolist()


def test_a_crossing_by_hand():
    # Both drive 10 m/s; the second reaches the crossing point 1.5 s later. Places may differ by SAME_PLACE, which saves time.
    found = times(straight((-20, 0), 0, 10), straight((0, -35), np.pi / 2, 10))
    assert len(found) == 1
    assert 1.5 - SAME_PLACE * np.sqrt(2) / 10 - DT <= found[0] <= 1.5


def test_followers_and_strangers_have_none():
    assert times(straight((-20, 0), 0, 10), straight((-30, 0), 0, 10)) == []
    assert times(straight((-20, 0), 0, 10), straight((-20, 9), 0, 10)) == []
    assert times(straight((-20, 0), 0, 10), straight((0, 35), np.pi / 2, 10)) == []


def test_visits_too_far_apart_in_time_are_none():
    slow = straight((0, -60), np.pi / 2, 5, steps=140)
    assert times(straight((-10, 0), 0, 10, steps=140), slow) == []


def by_loops(motion: Trajectories) -> list[float]:
    found = []
    for a in range(len(motion.valid)):
        for b in range(a):
            least = np.inf
            for s in np.flatnonzero(motion.valid[a]):
                for t in np.flatnonzero(motion.valid[b]):
                    angle = abs((motion.heading[a, s] - motion.heading[b, t] + np.pi) % (2 * np.pi) - np.pi)
                    if np.hypot(*(motion.position[a, s] - motion.position[b, t])) < SAME_PLACE and angle > CROSSING:
                        least = min(least, abs(s - t) * DT)
            if least <= LONGEST:
                found.append(least)
    return found


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_they_are_those_of_loops(seed):
    random = np.random.default_rng(seed)
    vehicles = []
    for _ in range(4):
        heading, speed = random.uniform(-3, 3), random.uniform(2, 12)
        start = random.uniform(-4, 4, 2) - random.uniform(5, 20) * np.array([np.cos(heading), np.sin(heading)])
        vehicles.append(straight(start, heading, speed, 40, random.random(40) < 0.8))
    motion = stack(vehicles)
    motion.position[~motion.valid] = 1e6
    assert sorted(times(*vehicles)) == pytest.approx(sorted(by_loops(motion)), abs=1e-5)
