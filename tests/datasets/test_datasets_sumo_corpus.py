"""The embedded corpus as a contract: what it promises about its scenarios holds on a tiny one."""

from contextlib import nullcontext
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import resample, wrap_angle
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.scenario import TARGET, VehicleKind
from drivegen.datasets.sumo_corpus import Plugin, write_part
from drivegen.layouts.corpus import Networks
from drivegen.sumo import corpus as simulated
from drivegen.sumo.corpus import CorpusSettings
from drivegen.sumo.parking import ParkingSettings
from drivegen.sumo.sensing import SensingSettings, sensed
from drivegen.sumo.traffic import Traffic, simulate
from drivegen.sumo.windows import WindowSettings, moves, overlapping_pairs, thrown
from stages.corpus import Params, main
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

CROSS = {
    "kind": "crossing",
    "control": "signals",
    "arms": [{"angle": a, "lanes_in": 2, "lanes_out": 2} for a in (0, 90, 180, 270)],
}
PARAMS = Params(
    seed=7,
    workers=1,
    scenarios={"train": 5, "test": 2},
    per_part=3,
    networks=Networks(real={"test": {"square": "tools/game/square/square.net.xml"}}, outside={}, own={"train": {"cross": CROSS}}),
    only=(),
    outside="",
    density={"real": (10.0, 15.0), "own": (10.0, 15.0)},
    own_share=0.5,
    settings=CorpusSettings(
        most_vehicles=60,
        warm_up=10.0,
        most_windows_per_run=1,
        lateral_resolution=0.8,
        fast_density=(15.0, 30.0),
        exit_speed=(5.0, 15.0),
        time_limit=60.0,
        parking=ParkingSettings(share=0.0, fastest=14.0, spacing=6.5, taken=0.6, gap=(0.2, 0.5), from_end=12.0),
        window=WindowSettings(
            steps=110, radius=150.0, map_radius=100.0, apart=20.0, focal_travel=8.0, fewest=4, moving_share=0.6
        ),
        sensing=SensingSettings(share=0.0, occlusion=True, position_noise=0.1, heading_noise=0.01, noise_time=0.6),
        without_signals=0.0,
    ),
)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("corpus")
    main(PARAMS, folder)
    return folder


@pytest.fixture(scope="module")
def logs(corpus: Path) -> list[RecordedLog]:
    plugin = Plugin(corpus)
    return [plugin.read(split, scene) for split in ("train", "test") for scene in plugin.scenes(split)]


def test_as_many_scenarios_as_asked_from_networks_of_their_split_alone(corpus, logs):
    plugin = Plugin(corpus)
    assert [len(plugin.scenes(split)) for split in ("train", "val", "test")] == [5, 0, 2]
    assert [log.city for log in logs] == ["cross"] * 5 + ["square"] * 2
    assert all(log.source == "SUMO corpus (simulated)" for log in logs)


def test_the_focal_vehicle_is_seen_throughout_and_drives_and_most_others_move(logs):
    for log in logs:
        assert log.motion.valid[log.focal].all()
        assert log.motion.steps == 110
        assert np.hypot(*(log.motion.position[log.focal, -1] - log.motion.position[log.focal, 0])) >= 8.0
        assert moves(log.motion).mean() >= 0.6


def test_boxes_are_known_and_never_overlap(logs):
    for log in logs:
        assert np.isfinite(log.size).all()
        assert len(overlapping_pairs(log.motion, log.size)) == 0


def test_vehicles_stand_on_the_map_that_comes_with_them(logs):
    for log in logs:
        log.map.validate()
        points = np.concatenate([resample(line, 1.0) for line in log.map.centreline.lines()])
        near = np.hypot(*(log.motion.position[log.motion.valid][::50, None] - points).T).min(0)
        assert near.max() < 3.5  # a lane's width; they stand beside its centre while they change lanes
        assert log.signals.state.shape == (len(log.signals.lane), 110)
        assert len(log.signals) > 0


def test_windows_say_how_often_they_occur(logs):
    """An hour of five cars or more that drive on a crossing holds hundreds of windows and not millions."""
    per_city = {city: sum(log.per_hour for log in logs if log.city == city) for city in ("cross", "square")}
    assert all(log.per_hour > 0 for log in logs)
    assert all(3600 / 11 <= total < 3600 / 11 * 2 * PARAMS.settings.most_vehicles for total in per_city.values())


def test_files_have_the_official_columns_and_one_row_group_a_scenario(corpus):
    files = sorted((corpus / "train").glob("tracks-*.parquet"))
    assert [file.name for file in files] == ["tracks-cross-000.parquet", "tracks-cross-001.parquet"]
    assert pq.ParquetFile(files[0]).num_row_groups == 3
    assert pq.read_schema(files[0]).names[:4] == ["observed", "track_id", "object_type", "object_category"]
    assert len(pq.read_schema(files[0])) == 20


def test_two_workers_write_the_same_bytes(corpus, tmp_path):
    main(replace(PARAMS, workers=2), tmp_path)
    names = sorted(path.relative_to(corpus) for path in corpus.rglob("*") if path.is_file())
    assert names == sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    assert all((corpus / name).read_bytes() == (tmp_path / name).read_bytes() for name in names)


def test_a_network_in_two_splits_is_refused(tmp_path):
    twice = {"train": {"a": "tools/game/square/square.net.xml"}, "test": {"b": "tools/game/square/square.net.xml"}}
    with pytest.raises(UnusableInput, match="train and test"):
        main(replace(PARAMS, networks=replace(PARAMS.networks, real=twice)), tmp_path)


def test_only_named_networks_are_simulated_and_give_the_same_bytes(corpus, tmp_path):
    main(replace(PARAMS, only=("cross",)), tmp_path)
    names = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*.parquet"))
    assert names == sorted(path.relative_to(corpus) for path in corpus.rglob("*cross*.parquet"))
    assert all((corpus / name).read_bytes() == (tmp_path / name).read_bytes() for name in names)


def test_a_name_that_no_network_has_is_refused(tmp_path):
    with pytest.raises(UnusableInput, match="'ring'"):
        main(replace(PARAMS, only=("cross", "ring")), tmp_path)


def test_a_density_for_something_else_is_refused(tmp_path):
    with pytest.raises(UnusableInput, match="density"):
        main(replace(PARAMS, density={"real": (10.0, 15.0)}), tmp_path)


def test_nobody_is_thrown_about_and_bends_are_taken_as_people_take_them(logs):
    for log in logs:
        assert not thrown(log.motion).any()
        turn = np.abs(wrap_angle(np.diff(log.motion.heading, axis=-1))) / 0.1 * log.motion.speed[:, 1:]
        both = log.motion.valid[:, 1:] & log.motion.valid[:, :-1]
        assert np.quantile(turn.max(-1, where=both, initial=0.0), 0.9) < 4.5


def test_a_jump_and_a_spin_are_seen(logs):
    motion = logs[0].motion[logs[0].motion.valid.all(-1)][:1]
    faster, spun = motion.velocity.copy(), motion.heading.copy()
    faster[:, 50:] += 1.0
    spun[:, 50:] += 2.0
    driving = np.full_like(motion.velocity, 5.0)
    assert thrown(replace(motion, velocity=faster)).all()
    assert thrown(replace(motion, velocity=driving, heading=spun)).all()
    assert not thrown(motion).any()


def test_unsound_networks_are_refused_by_name(tmp_path):
    unsound = {"train": {"cross": {"kind": "crossing", "arms": []}}}
    with pytest.raises(UnusableInput, match="'cross'"):
        main(replace(PARAMS, networks=replace(PARAMS.networks, own=unsound)), tmp_path)


def test_what_was_written_is_read_back(tmp_path):
    written = busy_crossing(110)
    write_part(tmp_path / "val", "x-000", [written])
    plugin = Plugin(tmp_path)
    log = plugin.read("val", written.scenario_id)
    assert written.log is not None
    assert np.allclose(log.motion.position, written.log.position, atol=1e-3)
    assert np.array_equal(log.signals.state, written.signals.state)
    assert np.array_equal(log.map.links, written.map.links)
    assert all(path.is_file() for path in plugin.files("val", written.scenario_id))


def test_damaged_and_missing_files_are_refused_by_name(tmp_path):
    with pytest.raises(UnusableInput, match="nowhere"):
        Plugin(tmp_path / "nowhere")
    write_part(tmp_path / "val", "x-000", [busy_crossing(20)])
    with pytest.raises(UnusableInput, match="no scenario 'y'"):
        Plugin(tmp_path).read("val", "y")
    tracks = tmp_path / "val" / "tracks-x-000.parquet"
    tracks.write_bytes(tracks.read_bytes()[:500])
    with pytest.raises(UnusableInput, match="tracks-x-000") as caught:
        Plugin(tmp_path).read("val", "crossing-0")
    assert caught.value.reason == "truncated"


@pytest.mark.parametrize("name", ["tracks-x-000.parquet", "maps-x-000.parquet"])
def test_a_changed_bit_is_seen(tmp_path, name):
    write_part(tmp_path / "val", "x-000", [busy_crossing(20)])
    raw = bytearray((tmp_path / "val" / name).read_bytes())
    raw[len(raw) // 3] ^= 1
    (tmp_path / "val" / name).write_bytes(raw)
    with pytest.raises(UnusableInput, match=rf"{name} .*run the stage `corpus` again") as caught:
        Plugin(tmp_path).read("val", "crossing-0")
    assert caught.value.reason == "damaged"


def test_tracks_of_another_run_than_the_maps_are_refused(tmp_path):
    for folder, names in (("one", ("a", "b")), ("two", ("b", "a"))):
        write_part(tmp_path / folder / "val", "x-000", [busy_crossing(20, name) for name in names])
    (tmp_path / "one/val/tracks-x-000.parquet").write_bytes((tmp_path / "two/val/tracks-x-000.parquet").read_bytes())
    with pytest.raises(UnusableInput, match="tracks of another scenario") as caught:
        Plugin(tmp_path / "one").read("val", "a")
    assert caught.value.reason == "damaged"


def test_a_part_that_is_not_written_to_its_end_does_not_exist(tmp_path):
    write_part(tmp_path / "val", "x-000", [busy_crossing(20)])
    with pytest.raises(UnusableInput, match="has no log"):
        write_part(tmp_path / "val", "x-000", [replace(busy_crossing(20), log=None)])
    assert Plugin(tmp_path).scenes("val") == []


def row_of_cars(steps: int = 20):
    """The target looks along a lane at two cars one behind the other; a third one drives in the next lane."""
    roads = straight_road(400)
    lanes = [roads.centreline[0].astype(np.float64), roads.centreline[1].astype(np.float64)]
    motions = [drive(lanes[lane], start, 10, steps) for lane, start in ((0, 20), (0, 40), (0, 52), (1, 40))]
    return scenario(roads, stack(motions))


def test_occlusion_hides_who_is_behind_another_and_never_the_target():
    seen = sensed(row_of_cars(), "AV", SensingSettings(1.0, True, 0.0, 0.0, 0.6), np.random.default_rng(0))
    assert seen.vehicles.track_id.tolist() == ["track-0", "track-1", "track-3"]
    assert seen.log is not None
    assert seen.log.valid[TARGET].all()


def test_noise_has_the_asked_size_and_lasts_and_velocities_follow_it():
    truth = row_of_cars(100)
    assert truth.log is not None
    errors = []
    for seed in range(20):
        noisy = sensed(truth, "AV", SensingSettings(1.0, False, 0.2, 0.02, 0.6), np.random.default_rng(seed))
        assert noisy.log is not None
        assert np.array_equal(noisy.vehicles.position, noisy.log.position[:, 0])
        errors.append((noisy.log.position - truth.log.position, noisy.log.velocity - truth.log.velocity))
    off, faster = (np.stack(parts) for parts in zip(*errors, strict=True))
    assert np.std(off) == pytest.approx(0.2, rel=0.1)
    later = (off[:, :, 6:] * off[:, :, :-6]).mean() / off.var()
    assert later == pytest.approx(np.exp(-0.5), abs=0.1)  # 0.6 s later
    assert faster[:, :, 1:-1] == pytest.approx((off[:, :, 2:] - off[:, :, :-2]) / 0.2, abs=1e-3)


def test_a_share_of_runs_is_measured_with_errors_and_a_share_of_training_runs_tells_no_signals(corpus, tmp_path):
    sensing = replace(PARAMS.settings.sensing, share=1.0)
    main(replace(PARAMS, settings=replace(PARAMS.settings, sensing=sensing, without_signals=1.0)), tmp_path)
    truth, measured = Plugin(corpus), Plugin(tmp_path)
    for split, told in (("train", False), ("test", True)):
        assert truth.scenes(split) == measured.scenes(split)
        for scene in truth.scenes(split):
            a, b = truth.read(split, scene), measured.read(split, scene)
            assert len(a.signals) > 0
            assert (len(b.signals) > 0) == told
            assert not np.allclose(a.motion.position[a.focal], b.motion.position[b.focal], atol=1e-3)
            assert set(b.track_id) <= set(a.track_id)


def test_parked_cars_come_on_top_of_the_same_traffic_and_touch_nobody(corpus, tmp_path):
    main(replace(PARAMS, settings=replace(PARAMS.settings, parking=replace(PARAMS.settings.parking, share=1.0))), tmp_path)
    empty, full = Plugin(corpus), Plugin(tmp_path)
    cars = 0
    for split in ("train", "test"):
        assert empty.scenes(split) == full.scenes(split)
        for scene in empty.scenes(split):
            a, b = empty.read(split, scene), full.read(split, scene)
            stands = np.char.startswith(b.track_id, "parked-")
            assert a.per_hour == b.per_hour
            assert sorted(a.track_id) == sorted(b.track_id[~stands])
            assert a.motion[np.argsort(a.track_id)].position.tobytes() == (
                b.motion[~stands][np.argsort(b.track_id[~stands])].position.tobytes()
            )
            assert len(overlapping_pairs(b.motion, b.size)) == 0
            assert (b.kind[stands] == VehicleKind.CAR).all()
            cars += stands.sum()
    assert cars > 10


@pytest.mark.parametrize("barren", [10, 16])
def test_a_few_barren_runs_end_no_corpus_and_many_do(corpus: Path, monkeypatch: pytest.MonkeyPatch, barren: int) -> None:
    cut, drive_once, runs = simulated.cut_windows, cache(lambda: simulate(*first)), count()
    first: list[object] = []

    def driven(*run: object) -> Traffic:
        first[:] = first or run
        return drive_once()

    monkeypatch.setattr(simulated, "simulate", driven)
    monkeypatch.setattr(simulated, "cut_windows", lambda *args: iter(()) if next(runs) < barren else cut(*args))
    raw = (corpus / "networks" / "cross.net.xml").read_bytes()
    with pytest.raises(UnusableInput, match="no scenario in 16 runs") if barren == 16 else nullcontext():
        assert len(simulated.simulate_scenarios(raw, "cross", 0, 1, (10.0, 15.0), PARAMS.settings, 7)) == 1
