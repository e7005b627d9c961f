"""How hard tracks accelerate: along and across alike, what is usual for nothing, and standing at once for much."""

import numpy as np

from drivegen.adversaries.shared.strain import USUAL, WINDOW, strain
from drivegen.core.scenario import Trajectories

TIME = np.arange(61) * 0.1


def track(along, across=None):
    """Places [m] at steps of 0.1 s, with the velocities that belong to them."""
    position = np.stack([along, np.zeros(61) if across is None else across], axis=-1)
    velocity = np.gradient(position, 0.1, axis=0)
    heading = np.arctan2(velocity[:, 1], velocity[:, 0])
    whole = (position, heading, velocity, np.ones(61, np.bool_))
    return Trajectories(*(np.asarray(array)[np.newaxis] for array in whole))


def test_only_what_is_beyond_the_usual_counts_whatever_its_direction():
    braking, speeding = 20 * TIME - 0.5 * 3 * TIME**2, 5 * TIME + 0.5 * 3 * TIME**2
    radius = 20.0**2 / 3
    bend = track(radius * np.sin(20 * TIME / radius), radius * (1 - np.cos(20 * TIME / radius)))
    for hard in (track(braking), track(speeding), bend):
        np.testing.assert_allclose(strain(hard), 3 - USUAL, atol=0.02)
    assert strain(track(10 * TIME)) == 0
    assert strain(track(10 * TIME + 0.5 * TIME**2)) == 0


def test_who_drives_and_stands_at_once_strains_most_and_what_is_not_there_not_at_all():
    frozen = track(np.zeros(61))
    frozen.velocity[0, 0] = 10.0, 0.0
    np.testing.assert_allclose(strain(frozen), 10 / 0.5 - USUAL, rtol=1e-6)
    gone = track(np.where(TIME < 3, 10 * TIME, 1e6))
    gone.valid[0, 30:] = False
    assert strain(gone) == 0


def test_array_by_array_it_is_the_same():
    random = np.random.default_rng(3)
    position = np.cumsum(random.normal(0, 1, (40, 61, 2)), axis=1).astype(np.float32)
    velocity = random.normal(0, 5, (40, 61, 2)).astype(np.float32)
    there = random.random((40, 61)) < 0.9
    velocities = np.concatenate([velocity[:, :1], np.diff(position.astype(np.float64), axis=1) / 0.1], axis=1)
    known = there & np.concatenate([there[:, :1], there[:, :-1]], axis=1)
    change = np.linalg.norm(velocities[:, WINDOW:] - velocities[:, :-WINDOW], axis=-1) / (WINDOW * 0.1)
    expected = np.where(known[:, WINDOW:] & known[:, :-WINDOW], change, 0.0).max(axis=1)
    found = strain(Trajectories(position, np.zeros((40, 61), np.float32), velocity, there))
    np.testing.assert_allclose(found, np.maximum(expected - USUAL, 0), rtol=1e-6)
