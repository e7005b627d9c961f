"""Sensor logs: frames, poses, velocities."""

from pathlib import Path

import numpy as np
import pytest

from drivegen.av2.sensor import EGO_CENTRE, EGO_SIZE, fitted_velocity, read_sensor_log
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import VehicleKind
from tests.small_datasets import EGO_SPEED, sensor_log


def test_boxes_are_turned_and_moved_by_the_pose_of_their_frame(tmp_path: Path) -> None:
    sensor_log(tmp_path / "log", 40)
    log = read_sensor_log(tmp_path / "log")
    assert log.track_id.tolist() == ["bus", "car", "walker", "AV"]
    assert log.kind.tolist() == [VehicleKind.BUS, VehicleKind.CAR, VehicleKind.PEDESTRIAN, VehicleKind.CAR]
    assert log.skipped == {"CONSTRUCTION_CONE": 1}
    assert log.city == "pittsburgh"
    np.testing.assert_allclose(log.motion.heading, np.pi / 4, atol=1e-5)
    bus, car, _, ego = log.motion.position + log.road_map.origin
    along = np.array([1.0, 1.0]) / np.sqrt(2)
    np.testing.assert_allclose(ego[0], 100 + EGO_CENTRE * along, atol=1e-3)
    np.testing.assert_allclose(car - ego, np.tile((10 - EGO_CENTRE) * along, (40, 1)), atol=1e-3)
    np.testing.assert_allclose(bus, np.tile(bus[0], (40, 1)), atol=1e-3)


def test_velocities_are_those_of_the_motion(tmp_path: Path) -> None:
    sensor_log(tmp_path / "log", 40)
    bus, car, _, ego = read_sensor_log(tmp_path / "log").motion.speed
    np.testing.assert_allclose(bus, 0, atol=1e-3)
    np.testing.assert_allclose(car[1:], EGO_SPEED, atol=1e-3)
    np.testing.assert_allclose(ego[1:], EGO_SPEED, atol=1e-3)


def test_the_ego_has_the_annotated_car_s_size(tmp_path: Path) -> None:
    sensor_log(tmp_path / "log", 40)
    np.testing.assert_allclose(read_sensor_log(tmp_path / "log").size[-1], EGO_SIZE, rtol=1e-6)


def test_a_frame_without_its_pose_is_refused(tmp_path: Path) -> None:
    sensor_log(tmp_path / "log", 40, lost_pose=17)
    with pytest.raises(UnusableInput, match="pose") as caught:
        read_sensor_log(tmp_path / "log")
    assert caught.value.reason == "missing-poses"


def test_fitted_velocity_of_a_parabola_is_its_slope_a_fifth_of_a_second_ago() -> None:
    t = np.arange(20) * 0.1
    position = np.stack([3 * t + t**2, -2 * t], axis=-1)[None].astype(np.float32)
    found = fitted_velocity(position, np.ones((1, 20), np.bool_))[0]
    np.testing.assert_allclose(found[4:, 0], 3 + 2 * t[2:-2], atol=1e-4)
    np.testing.assert_allclose(found[1:, 1], -2, atol=1e-4)


def test_gaps_do_not_disturb_a_fitted_velocity_and_a_lone_point_has_none() -> None:
    position = np.stack([np.arange(12.0), np.zeros(12)], axis=-1)[None].astype(np.float32)
    valid = np.ones((1, 12), np.bool_)
    valid[0, [3, 7, 8, 9, 10]] = False
    position[~valid] = 1e6
    found = fitted_velocity(position, valid)[0]
    np.testing.assert_allclose(found[[1, 2, 4, 5, 6], 0], 10.0, atol=1e-4)
    assert np.isnan(found[[0, 3, 7, 10, 11]]).all()


def test_a_velocity_does_not_know_where_its_track_goes_next() -> None:
    position = np.random.default_rng(3).normal(size=(2, 30, 2)).astype(np.float32)
    other = position.copy()
    other[:, 12:] += 50
    there = np.ones((2, 30), np.bool_)
    np.testing.assert_array_equal(fitted_velocity(position, there)[:, :12], fitted_velocity(other, there)[:, :12])
