"""Central differences: by hand, against Waymo's padding with NaN, and where they count."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.scenario import DT, Trajectories
from drivegen.metrics.kinematics import kinematics, within

SEEDS = st.integers(0, 2**32 - 1)


def motion(position, heading) -> Trajectories:
    position, heading = np.asarray(position, np.float32), np.asarray(heading, np.float32)
    return Trajectories(position, heading, np.zeros_like(position), np.ones(heading.shape, np.bool_))


def central_diff(values, pad=np.nan):
    """waymo_open_dataset's trajectory_features.central_diff over the last axis."""
    inner = (values[..., 2:] - values[..., :-2]) / 2
    ends = np.full((*values.shape[:-1], 1), pad)
    return np.concatenate([ends, inner, ends], axis=-1)


def waymo_features(position, heading):
    """compute_kinematic_features in two dimensions: speed, acceleration, angular speed, angular acceleration."""

    def wrap(angle):
        return (angle + np.pi) % (2 * np.pi) - np.pi

    speed = np.hypot(central_diff(position[..., 0]), central_diff(position[..., 1])) / DT
    turn = wrap(central_diff(heading) * 2) / 2
    return speed, central_diff(speed) / DT, turn / DT, wrap(central_diff(turn) * 2) / 2 / DT**2


def test_constant_acceleration_on_a_circle_by_hand():
    time = np.arange(30) * DT
    along, radius = 4 * time + time**2, 20.0
    position = radius * np.stack([np.sin(along / radius), 1 - np.cos(along / radius)], axis=-1)
    found = kinematics(motion(position, along / radius))
    np.testing.assert_allclose(found.speed[5:20], (4 + 2 * time)[5:20], rtol=1e-3)
    np.testing.assert_allclose(found.acceleration[5:20], 2.0, rtol=1e-2)
    np.testing.assert_allclose(found.jerk[5:20], 0.0, atol=0.1)
    np.testing.assert_allclose(found.turning[5:20], ((4 + 2 * time) / radius)[5:20], rtol=1e-3)
    np.testing.assert_allclose(found.lateral[5:20], ((4 + 2 * time) ** 2 / radius)[5:20], rtol=1e-2)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_they_are_waymo_s_features_where_known(seed):
    random = np.random.default_rng(seed)
    position = np.cumsum(random.normal(0, 1, (3, 12, 2)), axis=1).astype(np.float32)
    heading = np.cumsum(random.normal(0, 0.4, (3, 12)), axis=1).astype(np.float32)
    found = kinematics(motion(position, heading))
    known = np.ones((3, 12), np.bool_)
    ours = ((found.speed, 1), (found.acceleration, 2), (found.turning, 1), (found.angular_acceleration, 2))
    for (values, order), theirs in zip(ours, waymo_features(position, heading), strict=True):
        mask = within(known, order)
        np.testing.assert_array_equal(mask, np.isfinite(theirs))
        np.testing.assert_allclose(values[mask], theirs[mask], atol=5e-3)


def test_a_gap_spoils_its_neighbours_and_no_more():
    known = np.array([True] * 5 + [False] + [True] * 6)
    assert np.flatnonzero(~within(known, 0)).tolist() == [5]
    assert np.flatnonzero(~within(known, 1)).tolist() == [0, 4, 6, 11]
    assert within(known, 2)[[2, 8, 9]].all()
    assert not within(known, 2)[[0, 1, 3, 5, 7, 10, 11]].any()


def test_turning_goes_the_short_way_round():
    found = kinematics(motion(np.zeros((3, 2)), [3.1, 3.1, -3.1]))
    np.testing.assert_allclose(found.turning[1], (2 * np.pi - 6.2) / (2 * DT), rtol=1e-4)
