"""Argoverse 2 folders: what is exported is read back, and what is broken is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivegen.av2.export import export_scenario
from drivegen.av2.folder import read_folder, read_table
from drivegen.av2.schema import COLUMNS, OBSERVED_STEPS, TrackCategory
from drivegen.av2.signals import read_signals
from drivegen.av2.tracks import read_log, track_table
from drivegen.core import safe_parquet
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import FARTHEST, NO_TRACK
from drivegen.core.scenario import Scenario, VehicleKind
from drivegen.core.signals import Signals, SignalState
from tests.refusals import assert_one_sentence
from tests.scenes import any_scenario, busy_crossing

FIRST = ["observed", "track_id", "object_type", "object_category", "timestep"]
STATE = ["position_x", "position_y", "heading", "velocity_x", "velocity_y"]
LAST = ["scenario_id", "start_timestamp", "end_timestamp", "num_timestamps", "focal_track_id", "city"]


def table(scene: Scenario) -> pa.Table:
    assert scene.log is not None
    return track_table(scene, scene.log, scene.scenario_id)


@given(st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_tracks_come_back_bit_by_bit(seed: int) -> None:
    scene = any_scenario(seed)
    assert scene.log is not None
    log = read_log(table(scene), scene.map, "test", "x.parquet")
    vehicles = len(scene.vehicles)
    assert log.track_id.tolist() == [*scene.vehicles.track_id, *scene.context.track_id]
    assert log.kind.tolist() == [*scene.vehicles.kind, *scene.context.kind]
    np.testing.assert_array_equal(log.size, np.concatenate([scene.vehicles.size, scene.context.size]))
    assert log.focal == 0
    assert log.ego == NO_TRACK
    for got, given_ in ((log.motion[:vehicles], scene.log), (log.motion[vehicles:], scene.context.motion)):
        seen = given_.valid[:, : got.steps]
        np.testing.assert_array_equal(got.valid, seen)
        assert not given_.valid[:, got.steps :].any()
        for name in ("position", "velocity"):
            np.testing.assert_array_equal(getattr(got, name)[seen], getattr(given_, name)[:, : got.steps][seen])
        np.testing.assert_allclose(np.cos(got.heading - given_.heading[:, : got.steps])[seen], 1.0, atol=1e-6)


def test_the_file_has_the_official_columns_and_our_sizes(tmp_path: Path) -> None:
    scene = busy_crossing()
    assert scene.log is not None
    folder = export_scenario(scene, scene.log, tmp_path, "crossing-0")
    written = pq.read_table(folder / "scenario_crossing-0.parquet")
    assert written.column_names == [*FIRST, *STATE, *LAST, "length", "width", "height", "truck"]
    assert written.schema.equals(COLUMNS)
    assert written["timestep"].to_pylist()[:101] == list(range(101))
    assert written["num_timestamps"][0].as_py() == 101
    observed, step = written["observed"].to_numpy(), written["timestep"].to_numpy()
    np.testing.assert_array_equal(observed, step < OBSERVED_STEPS)


def test_exported_folders_are_read_back_with_map_and_signals(tmp_path: Path) -> None:
    scene = any_scenario(3)
    assert scene.log is not None
    log = read_folder(export_scenario(scene, scene.log, tmp_path, "any-0"), "test")
    np.testing.assert_array_equal(log.signals.lane, scene.signals.lane)
    np.testing.assert_array_equal(log.signals.state, scene.signals.state[:, : log.motion.steps])
    np.testing.assert_array_equal(log.map.lane_id, scene.map.lane_id)
    assert (log.scenario_id, log.city, log.source) == ("any-0", scene.city, "test")


def test_the_same_scenario_gives_the_same_bytes(tmp_path: Path) -> None:
    scene = any_scenario(5)
    assert scene.log is not None
    one, two = (export_scenario(scene, scene.log, tmp_path / word, "any-0") for word in "ab")
    assert {p.name: p.read_bytes() for p in one.iterdir()} == {p.name: p.read_bytes() for p in two.iterdir()}


def test_trucks_are_vehicles_buses_are_buses_and_the_target_is_focal() -> None:
    scene = busy_crossing()
    kind, size = scene.vehicles.kind.copy(), scene.vehicles.size.copy()
    kind[1], kind[2] = VehicleKind.TRUCK, VehicleKind.BUS
    size[1] = (8.0, 2.5, 3.0)
    scene = replace(scene, vehicles=replace(scene.vehicles, kind=kind, size=size))
    written = table(scene)
    of_track = dict(zip(written["track_id"].to_pylist(), written["object_type"].to_pylist(), strict=True))
    assert [of_track[f"track-{i}"] for i in range(3)] == ["vehicle", "vehicle", "bus"]
    category = dict(zip(written["track_id"].to_pylist(), written["object_category"].to_pylist(), strict=True))
    assert category["track-0"] == TrackCategory.FOCAL
    assert category["track-1"] == TrackCategory.SCORED
    assert read_log(written, scene.map, "test", "x").kind[:3].tolist() == [VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS]


def test_static_objects_are_skipped_and_counted() -> None:
    scene = busy_crossing(5)
    types = pa.array(["static" if word == "track-3" else "vehicle" for word in table(scene)["track_id"].to_pylist()])
    log = read_log(table(scene).set_column(2, "object_type", types), scene.map, "test", "x")
    assert log.skipped == {"static": 1}
    assert len(log.kind) == 7


def test_time_lasts_as_long_as_the_tracks_whatever_num_timestamps_says() -> None:
    scene = busy_crossing(20)
    claimed = table(scene).set_column(13, "num_timestamps", pa.array([110] * table(scene).num_rows))
    assert read_log(claimed, scene.map, "test", "x").motion.steps == 20


def changed(name: str, values: object) -> pa.Table:
    whole = table(busy_crossing(4))
    column = whole[name].to_pylist()
    column[1] = values
    return whole.set_column(whole.column_names.index(name), name, pa.array(column))


@pytest.mark.parametrize(
    ("tracks", "reason"),
    [
        (table(busy_crossing(4)).drop_columns(["heading"]), "missing-columns"),
        (table(busy_crossing(4)).slice(0, 0), "no-rows"),
        (changed("position_x", float("nan")), "not-a-number"),
        (changed("velocity_y", float("inf")), "not-a-number"),
        (changed("position_y", None), "not-a-number"),
        (changed("position_y", 1e9), "out-of-range"),
        (changed("timestep", -1), "out-of-range"),
        (changed("timestep", 10**9), "out-of-range"),
        (changed("timestep", 0), "duplicate-rows"),
        *((changed(name, "other"), "mixed-scenarios") for name in ("scenario_id", "focal_track_id", "city")),
        (changed("track_id", "x" * 201), "bad-id"),
        (changed("scenario_id", "x" * 201), "bad-id"),
        (table(busy_crossing(4)).append_column("heading", table(busy_crossing(4))["heading"]), "duplicate-columns"),
    ],
)
def test_unusable_tracks_are_refused_with_a_reason(tracks: pa.Table, reason: str) -> None:
    with pytest.raises(UnusableInput, match=r"tracks\.parquet") as caught:
        read_log(tracks, busy_crossing(4).map, "test", "tracks.parquet")
    assert caught.value.reason == reason


@pytest.mark.parametrize(("rows", "said"), [(1, "nan is no number$"), (3, "nan is no number, nor are 2 others$")])
def test_what_is_no_number_is_counted(rows: int, said: str) -> None:
    whole = table(busy_crossing(4))
    values = pa.array([float("nan")] * rows + whole["heading"].to_pylist()[rows:])
    bad = whole.set_column(whole.column_names.index("heading"), "heading", values)
    with pytest.raises(UnusableInput, match=f"column heading, row 0: {said}"):
        read_log(bad, busy_crossing(4).map, "test", "x")


def test_words_where_numbers_belong_are_refused() -> None:
    whole = table(busy_crossing(4))
    bad = whole.set_column(5, "position_x", pa.array(["here"] * whole.num_rows))
    with pytest.raises(UnusableInput, match="position_x"):
        read_log(bad, busy_crossing(4).map, "test", "x")


def test_tracks_of_static_objects_only_are_refused() -> None:
    whole = table(busy_crossing(4))
    bad = whole.set_column(2, "object_type", pa.array(["background"] * whole.num_rows))
    with pytest.raises(UnusableInput) as caught:
        read_log(bad, busy_crossing(4).map, "test", "x")
    assert caught.value.reason == "no-tracks"


@given(st.data())
@settings(max_examples=40, deadline=None)
def test_a_damaged_file_is_refused_by_its_name_or_is_a_log_within_bounds(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    scene = busy_crossing(4)
    path = tmp_path_factory.mktemp("damaged") / "scenario_x.parquet"
    pq.write_table(table(scene), path)
    raw = bytearray(path.read_bytes())
    for place, value in data.draw(st.lists(st.tuples(st.integers(0, len(raw) - 1), st.integers(0, 255)), max_size=4)):
        raw[place] = value
    path.write_bytes(raw[: data.draw(st.integers(0, len(raw)))])
    try:
        log = read_log(read_table(path), scene.map, "test", str(path))
    except UnusableInput as refusal:
        assert_one_sentence(refusal, str(path))
    else:
        assert log.motion.valid.any()
        assert np.abs(log.motion.position[log.motion.valid]).max() <= FARTHEST
        assert np.abs(log.motion.heading).max() <= np.float32(np.pi)
        assert len(log.track_id) == len(log.kind) == len(log.size) == len(log.motion.valid)


def test_a_folder_without_its_files_says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match=r"scenario_<id>\.parquet"):
        read_folder(tmp_path, "test")


def test_a_column_that_is_there_twice_and_a_folder_in_a_file_s_place_are_named(tmp_path: Path) -> None:
    scene = busy_crossing(4)
    assert scene.log is not None
    folder = export_scenario(scene, scene.log, tmp_path, "crossing-0")
    tracks, archive = folder / "scenario_crossing-0.parquet", folder / "log_map_archive_crossing-0.json"
    whole = pq.read_table(tracks)
    pq.write_table(whole.append_column("track_id", whole["track_id"]), tracks)
    with pytest.raises(UnusableInput, match="more than one column track_id"):
        read_folder(folder, "test")
    archive.unlink()
    archive.mkdir()
    with pytest.raises(UnusableInput, match="log_map_archive_crossing-0") as caught:
        read_folder(folder, "test")
    assert caught.value.reason == "truncated"


def test_a_list_of_many_elements_is_refused_before_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = table(busy_crossing(4))
    start = pa.array([0] + [1000] * whole.num_rows, pa.int32())
    lists = pa.ListArray.from_arrays(start, pa.array(np.zeros(1000)))
    pq.write_table(whole.set_column(whole.column_names.index("heading"), "heading", lists), tmp_path / "x.parquet")
    monkeypatch.setattr(safe_parquet, "MOST_VALUES", whole.num_rows * whole.num_columns + 900)
    with pytest.raises(UnusableInput, match=r"x\.parquet") as caught:
        read_table(tmp_path / "x.parquet")
    assert caught.value.reason == "too-large"


def test_a_size_that_nothing_has_is_none_and_heights_may_be_unknown() -> None:
    whole = table(busy_crossing(4))

    def sizes(name: str, value: float) -> NDArray[np.float32]:
        column = pa.array([value] * whole.num_rows)
        return read_log(whole.set_column(whole.column_names.index(name), name, column), busy_crossing(4).map, "test", "x").size

    assert np.isnan(sizes("length", 1e6)[:, :2]).all()
    for flat in (sizes("height", np.nan), read_log(whole.drop_columns("height"), busy_crossing(4).map, "test", "x").size):
        assert np.isnan(flat[:, 2]).all()
        np.testing.assert_array_equal(flat[:, :2], read_log(whole, busy_crossing(4).map, "test", "x").size[:, :2])


def test_a_short_truck_and_a_long_car_stay_what_they_are_and_without_our_column_length_tells() -> None:
    scene = busy_crossing()
    kind, size = scene.vehicles.kind.copy(), scene.vehicles.size.copy()
    kind[1], size[1, 0], size[2, 0] = VehicleKind.TRUCK, 5.2, 7.5
    written = table(replace(scene, vehicles=replace(scene.vehicles, kind=kind, size=size)))
    for there, expected in ((written, ("CAR", "TRUCK", "CAR")), (written.drop_columns("truck"), ("CAR", "CAR", "TRUCK"))):
        kinds = read_log(there, scene.map, "test", "x").kind[:3]
        assert tuple(VehicleKind(k).name for k in kinds.tolist()) == expected


def test_a_scenario_without_signals_over_one_with_them_has_none(tmp_path: Path) -> None:
    lit, dark = busy_crossing(11), any_scenario(3)
    lit = replace(lit, signals=Signals(np.array([8], np.int32), np.full((1, 11), SignalState.RED, np.uint8)))
    for scene, count in ((lit, 1), (replace(dark, signals=Signals.none(dark.steps)), 0)):
        assert scene.log is not None
        folder = export_scenario(scene, scene.log, tmp_path, "again")
        assert len(read_folder(folder, "test").signals) == count


def test_an_id_that_cannot_name_a_folder_is_refused(tmp_path: Path) -> None:
    scene = busy_crossing(4)
    assert scene.log is not None
    with pytest.raises(UnusableInput, match="cannot name a folder"):
        export_scenario(scene, scene.log, tmp_path, "../out")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("states", [["GG", "G"], ["GX"], ["GÜ"], [5], [None]])
def test_signals_of_unequal_lengths_or_unknown_letters_are_refused(states: list[object]) -> None:
    road_map = busy_crossing(5).map
    rows = [{"lane": int(road_map.lane_id[i]), "states": letters} for i, letters in enumerate(states)]
    with pytest.raises(UnusableInput, match="signals file"):
        read_signals(orjson.dumps({"signals": rows}), road_map, "signals.json")


def test_two_scenarios_in_one_file_are_refused_by_the_column_that_tells_them_apart(tmp_path: Path) -> None:
    one = table(busy_crossing(4))
    place = one.schema.get_field_index("scenario_id")
    other = one.set_column(place, "scenario_id", pa.array(["other"] * one.num_rows))
    file = tmp_path / "tracks.parquet"
    pq.write_table(pa.concat_tables([one, other]), file, row_group_size=one.num_rows)  # each group has its own dictionary
    with pytest.raises(UnusableInput, match=r"tracks\.parquet: column scenario_id has 2 values, and a file holds one scenario"):
        read_log(read_table(file), busy_crossing(4).map, "test", str(file))
