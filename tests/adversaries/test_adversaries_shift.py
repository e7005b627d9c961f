"""Shifted tracks: across by as much as was asked for, when it was asked for, and otherwise as they were."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegen.adversaries.shared.shift import Shift, shifted
from drivegen.core.geometry import rotate, unit, wrap_angle
from drivegen.core.scenario import DT, Trajectories

STEPS = 101


def straight(speed, heading=0.0, braking=0.0):
    """(1, T) one track along `heading`, slower by `braking` until it stands."""
    pace = np.maximum(speed - braking * DT * np.arange(STEPS), 0.0)
    way = np.concatenate([[0.0], np.cumsum((pace[1:] + pace[:-1]) / 2 * DT)])
    return _track(way[:, None] * unit(np.float64(heading)), np.full(STEPS, heading), pace)


def circle(speed, radius):
    """(1, T) to the left, from the origin along +x."""
    angle = speed / radius * DT * np.arange(STEPS)
    return _track(radius * np.stack([np.sin(angle), 1 - np.cos(angle)], -1), wrap_angle(angle), np.full(STEPS, float(speed)))


def _track(position, heading, pace):
    arrays = (position, heading, pace[:, None] * unit(heading))
    return Trajectories(*(array[None].astype(np.float32) for array in arrays), np.ones((1, STEPS), np.bool_))


def moved(track, offset, begin, seconds):
    return shifted(track, np.array([offset]), np.array([begin]), np.array([seconds]))


def test_across_by_as_much_as_asked_and_only_then():
    track = moved(straight(10.0), 3.5, 2.0, 4.0)
    left = track.position[0, :, 1]
    np.testing.assert_array_equal(left[: round(2.0 / DT) + 1], 0.0)
    assert left[round(4.0 / DT)] == pytest.approx(1.75, abs=1e-3)
    np.testing.assert_allclose(left[round(6.0 / DT) :], 3.5, atol=1e-5)
    assert (np.diff(left) >= 0).all()
    np.testing.assert_array_equal(track.position[0, :, 0], straight(10.0).position[0, :, 0])


@pytest.mark.parametrize("track", [straight(12.0, 2.5), circle(8.0, 40.0), straight(14.0, -1.0, 1.0)])
@pytest.mark.parametrize("offset", [3.0, -3.0])
def test_velocity_is_that_of_the_positions_and_heading_that_of_the_velocity(track, offset):
    track = moved(track, offset, 1.0, 3.0)
    driven = np.diff(track.position[0].astype(np.float64), axis=0) / DT
    middle = (track.velocity[0, 1:] + track.velocity[0, :-1]) / 2
    assert np.hypot(*(driven - middle).T).max() < 0.35
    moving = track.speed[0] > 0.5
    direction = np.arctan2(track.velocity[0, :, 1], track.velocity[0, :, 0])
    np.testing.assert_allclose(wrap_angle(direction - track.heading[0])[moving], 0.0, atol=1e-4)


def test_in_a_bend_who_moves_outwards_drives_farther():
    inside, outside = (moved(circle(8.0, 40.0), offset, 1.0, 2.0) for offset in (3.0, -3.0))
    for track, radius in ((inside, 37.0), (outside, 43.0)):
        assert np.hypot(*(track.position[0, 40:] - [0.0, 40.0]).T) == pytest.approx(radius, abs=0.02)
        assert track.speed[0, 40:] == pytest.approx(8.0 * radius / 40.0, abs=0.05)


def test_who_stands_does_not_slide():
    track = moved(straight(5.0, braking=2.5), 3.0, 1.5, 6.0)
    standing = np.flatnonzero(straight(5.0, braking=2.5).speed[0] == 0)
    assert np.ptp(track.position[0, standing], axis=0).max() == 0
    still = moved(straight(0.0), 3.0, 0.0, 3.0)
    np.testing.assert_array_equal(still.position, straight(0.0).position)
    np.testing.assert_array_equal(still.heading, straight(0.0).heading)


@given(offset=st.floats(-4, 4), begin=st.floats(0, 9), seconds=st.floats(0.5, 6), speed=st.floats(0, 30), turned=st.floats(-3, 3))
def test_a_turned_track_is_shifted_as_the_track_turned_and_starts_as_it_did(offset, begin, seconds, speed, turned):
    here, there = moved(straight(speed), offset, begin, seconds), moved(straight(speed, turned), offset, begin, seconds)
    np.testing.assert_allclose(rotate(here.position, np.float32(turned)), there.position, atol=1e-3)
    assert np.isfinite(there.position).all()
    assert np.isfinite(there.velocity).all()
    np.testing.assert_array_equal(there.position[:, 0], straight(speed, turned).position[:, 0])
    np.testing.assert_array_equal(there.velocity[:, 0], straight(speed, turned).velocity[:, 0])


def test_draws_are_within_bounds_and_differ_and_none_is_shifted_for_zero():
    tracks = Trajectories.joined([straight(10.0)] * 200)
    drawn = Shift(2.0, 3.0, 6.0).draw(tracks, np.random.default_rng(7))
    ends = drawn.position[:, -1, 1]
    assert np.abs(ends).max() <= 2.0
    assert ends.min() < -1.5
    assert ends.max() > 1.5
    lasts = (drawn.position[..., 1] != 0).argmax(axis=1)
    assert np.ptp(lasts) > 50
    np.testing.assert_array_equal(Shift(0.0, 3.0, 6.0).draw(tracks, np.random.default_rng(7)).position, tracks.position)
