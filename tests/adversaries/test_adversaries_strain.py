"""How hard tracks accelerate: along and across alike, what is usual for nothing, and standing at once for much."""

import numpy as np

from drivegen.adversaries.shared.strain import USUAL, strain
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
