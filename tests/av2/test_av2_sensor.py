"""Sensor logs: frames, poses, velocities."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pytest

from drivegen.av2.sensor import EGO_CENTRE, EGO_SIZE, count_steps, fitted_velocity, read_sensor_log
from drivegen.core import recorded_log, safe_parquet
from drivegen.core.errors import UnusableInput
from drivegen.core.safe_parquet import read_feather
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


def test_steps_are_counted_as_they_are_read_where_frames_are_missing(tmp_path: Path) -> None:
    sensor_log(tmp_path / "log", 40)
    file = next((tmp_path / "log").glob("annotations*.feather"))
    table = pyarrow.feather.read_table(file)
    times = np.unique(table["timestamp_ns"].to_numpy())
    kept = ~np.isin(table["timestamp_ns"].to_numpy(), times[10:20])
    pyarrow.feather.write_feather(table.filter(pa.array(kept)), file, compression="uncompressed")
    assert count_steps(tmp_path / "log") == read_sensor_log(tmp_path / "log").motion.steps == 40


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


def changed(folder: Path, file: str, name: str, column: pa.Array | None) -> Path:
    """A log whose file has another column in the place of one, or that one twice."""
    sensor_log(folder, 40)
    table = pa.feather.read_table(folder / file)
    at = table.column_names.index(name)
    table = table.append_column(name, table[name]) if column is None else table.set_column(at, name, column)
    pa.feather.write_feather(table, folder / file)
    return folder


ROWS = {"annotations.feather": 160, "city_SE3_egovehicle.feather": 40}


@pytest.mark.parametrize("file", ROWS)
@pytest.mark.parametrize("name", ["timestamp_ns", "qw", "tx_m"])
@pytest.mark.parametrize(
    ("value", "kind"),
    [
        ("x", pa.string()),
        ([1.0], pa.list_(pa.float64())),
        (0, pa.timestamp("ns")),
        (True, pa.bool_()),
        (float("nan"), pa.float64()),
        (float("inf"), pa.float64()),
        (None, None),
    ],
)
def test_columns_of_other_types_or_twice_are_refused_by_name(
    tmp_path: Path, file: str, name: str, value: object, kind: pa.DataType | None
) -> None:
    column = None if kind is None else pa.array([value] * ROWS[file], kind)
    with pytest.raises(UnusableInput, match=file):
        read_sensor_log(changed(tmp_path / "log", file, name, column))


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("length_m", 1e6, "out-of-range"),
        ("width_m", 0.0, "out-of-range"),
        ("tx_m", 1e7, "out-of-range"),
        ("timestamp_ns", 2**64 - 1, "out-of-range"),
        ("track_uuid", "x" * 201, "bad-id"),
        ("track_uuid", "x", "duplicate-rows"),
    ],
)
def test_absurd_boxes_are_refused(tmp_path: Path, name: str, value: object, reason: str) -> None:
    with pytest.raises(UnusableInput, match="annotations") as caught:
        read_sensor_log(changed(tmp_path / "log", "annotations.feather", name, pa.array(np.full(160, value))))
    assert caught.value.reason == reason


def test_columns_that_nobody_asked_for_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sensor_log(tmp_path / "log", 40)
    path = tmp_path / "log/annotations.feather"
    table = pa.feather.read_table(path)
    pa.feather.write_feather(table.append_column("more", pa.array([[0.0] * 9] * 160)), path)
    monkeypatch.setattr(safe_parquet, "MOST_VALUES", 160 * 13)
    assert read_feather(path, ["timestamp_ns"]).column_names == ["timestamp_ns"]
    assert len(read_sensor_log(tmp_path / "log").track_id) == 4


def test_many_states_are_refused_before_they_take_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sensor_log(tmp_path / "log", 40)
    monkeypatch.setattr(recorded_log, "MOST_CELLS", 4 * 40 - 1)
    with pytest.raises(UnusableInput, match="4 tracks over 40 steps"):
        read_sensor_log(tmp_path / "log")
