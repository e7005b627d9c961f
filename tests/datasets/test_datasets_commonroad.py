"""CommonRoad as a data set: scenes with different targets, and the real NGSIM recordings as they are."""

import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from drivegen.commonroad.recording import read_recording
from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap, project
from drivegen.core.intervals import recording
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.scenario import SPLITS, SizeSource, Trajectories, VehicleKind
from drivegen.datasets import commonroad
from drivegen.datasets._targets import LEAST_NEW, LONG, NEIGHBOURHOOD, spread_targets
from drivegen.ingest.selection import Settings, select
from drivegen.ingest.splits import Plan, items, unseen
from tests.commonroad_files import ROAD, car, obstacle, state, xml
from tests.futures import otherwise

REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[2].parent / "shared" / "data")) / "commonroad"
SETTINGS = Settings(target="focal", max_vehicles=16, first_step=0, horizon=100, map_radius=None, smallest_shrink=0.8)

real = pytest.mark.skipif(not REAL.is_dir(), reason=f"no real CommonRoad data in {REAL}")


def row_of_cars(count: int, steps: int = 90, apart: float = 10.0) -> Trajectories:
    motion = Trajectories.empty(count, steps)
    motion.position[..., 0] = apart * np.arange(count)[:, None] + 0.5 * np.arange(steps)
    motion.velocity[..., 0] = 5
    motion.valid[:] = True
    return motion


def cars(count: int) -> np.ndarray:
    return np.full(count, VehicleKind.CAR, np.uint8)


def test_targets_are_spread_until_every_long_track_is_shown_but_a_few() -> None:
    targets = spread_targets(cars(50), row_of_cars(50))
    shown = {
        car for target in targets for car in np.argsort(np.abs(np.arange(50) - target), kind="stable")[:NEIGHBOURHOOD].tolist()
    }
    assert len(set(targets)) == len(targets)
    assert len(shown) > 50 - LEAST_NEW
    assert len(targets) <= 5


@pytest.mark.parametrize(("few", "targets"), [(3, 1), (4, 2)])
def test_four_cars_that_no_scenario_shows_are_worth_another_and_three_are_not(few: int, targets: int) -> None:
    motion = row_of_cars(NEIGHBOURHOOD + few)
    motion.position[NEIGHBOURHOOD:, :, 0] += 1000
    assert len(spread_targets(cars(NEIGHBOURHOOD + few), motion)) == targets


def test_targets_do_not_depend_on_the_order_of_tracks() -> None:
    motion = row_of_cars(40)
    rng = np.random.default_rng(3)
    motion.position[:] += rng.uniform(0, 60, (40, 1, 2)).astype(np.float32)  # no ties
    order = rng.permutation(40)
    assert order[spread_targets(cars(40), motion[order])].tolist() == spread_targets(cars(40), motion)


def test_targets_move_are_vehicles_and_are_seen_for_long_from_the_start() -> None:
    motion, kind = row_of_cars(6), cars(6)
    kind[0] = VehicleKind.PEDESTRIAN
    motion.valid[1, 0] = False
    motion.valid[2, LONG // 2 :] = False
    motion.position[3] = motion.position[3, :1]
    assert set(spread_targets(kind, motion)) <= {4, 5}


def test_of_those_who_may_be_targets_the_first_frame_decides() -> None:
    motion, kind = row_of_cars(40), cars(40)
    motion.valid[::2, LONG // 2 :] = False
    chosen = spread_targets(kind, motion)
    other = otherwise(motion)
    other.valid[:] = motion.valid
    other.valid[::2, LONG // 3 :] = False
    assert chosen == spread_targets(kind, other)
    assert all(target % 2 for target in chosen)


def test_where_nobody_moves_or_is_seen_for_long_somebody_is_target_all_the_same() -> None:
    motion = row_of_cars(3, steps=20)
    motion.position[:] = motion.position[:, :1]
    assert len(spread_targets(cars(3), motion)) == 1
    assert spread_targets(np.full(3, VehicleKind.PEDESTRIAN, np.uint8), motion) == []


def test_a_long_recording_is_several_windows(tmp_path: Path) -> None:
    (tmp_path / "val").mkdir()
    raw = xml([*ROAD, car(1, 0, 0, speed=2.0, steps=250), car(2, 30, 0, speed=2.0, steps=100)])
    (tmp_path / "val" / "long.xml").write_bytes(raw)
    data = commonroad.Plugin(tmp_path)
    assert data.scenes("val") == ["long:000", "long:001"]
    first, second = (data.read("val", scene) for scene in data.scenes("val"))
    assert (first.motion.steps, second.motion.steps) == (110, 110)
    assert second.track_id.tolist() == ["1"]
    np.testing.assert_allclose(second.motion.position[0, 0] + second.map.origin, (22, 0), atol=1e-3)
    assert second.scenario_id == "long-001"


@pytest.mark.parametrize(("steps", "windows"), [(30, [30]), (150, [110]), (181, [110, 71]), (219, [110, 109]), (220, [110, 110])])
def test_a_rest_is_a_window_where_it_is_as_long_as_what_is_taken_of_every_recording(
    tmp_path: Path, steps: int, windows: list[int]
) -> None:
    (tmp_path / "val").mkdir()
    (tmp_path / "val" / "long.xml").write_bytes(xml([*ROAD, car(1, 0, 0, speed=2.0, steps=steps)]))
    data = commonroad.Plugin(tmp_path)
    assert [data.read("val", scene).motion.steps for scene in data.scenes("val")] == windows


@pytest.mark.parametrize("scene", ["scene", "a:b", "a:0", "../val/long:000", "long:7", ":0"])
def test_other_names_are_refused(tmp_path: Path, scene: str) -> None:
    (tmp_path / "val").mkdir()
    (tmp_path / "val" / "long.xml").write_bytes(xml([*ROAD, car(1, 0, 0)]))
    with pytest.raises(UnusableInput) as caught:
        commonroad.Plugin(tmp_path).read("val", scene)
    assert caught.value.reason == "no-such-scenario"


class Named:
    """A data set of recordings with three scenes each, of which only the names matter."""

    description = "names"

    def __init__(self, recordings: int) -> None:
        self.recordings = recordings

    def scenes(self, split: str) -> list[str]:
        return [f"{split}-{i}:{n:03d}" for i in range(self.recordings) for n in range(3)]


@pytest.mark.parametrize("recordings", [2, 7, 40])
def test_scenes_of_one_recording_are_never_both_trained_on_and_validated_on(recordings: int) -> None:
    plan = Plan("named", ("named",), {"named": "val"}, {}, ())
    train, val, test = ({item.partition(":")[0] for item in items(plan, lambda _: Named(recordings), split)} for split in SPLITS)
    assert train
    assert val
    assert len(train) + len(val) == recordings
    assert test == {f"named/val/val-{i}" for i in range(recordings)}


def test_recordings_that_show_the_same_cars_stay_together() -> None:
    class Freeway(Named):
        def scenes(self, split: str) -> list[str]:
            return [f"USA_US101-{n}_1_T-1:000" for n in (6, 7, 9, 20, 25, 28, 12, 17, 3)]

    plan = Plan("commonroad", ("commonroad",), {"commonroad": "val"}, {}, ())
    names = [[item.split("/")[-1] for item in items(plan, lambda _: Freeway(0), split)] for split in ("train", "val")]
    train, val = ({recording(name.replace(":", "-")) for name in of_split} for of_split in names)
    assert train
    assert val
    assert not train & val
    assert len(train | val) == 3


def test_only_the_recordings_that_are_named_are_measured_on_and_all_are_trained_on() -> None:
    plan = Plan("named", ("named",), {"named": "val"}, {}, ("val-1", "val-3"))
    train, val, test = (items(plan, lambda _: Named(4), split) for split in SPLITS)
    assert {item.partition(":")[0] for item in test} == {"named/val/val-1", "named/val/val-3"}
    assert len(train) + len(val) == 12


@real
def test_the_28_recordings_of_ngsim_are_18_groups_and_no_group_is_in_two_splits() -> None:
    groups = [{recording(f"{file.stem}-000") for file in (REAL / split).glob("*.xml")} for split in ("train", "val", "test")]
    assert sum(map(len, groups)) == len(set().union(*groups)) == 18


RECORDINGS = {
    ("train", "USA_Lanker-2_15_T-1"): ("Lanker", 81, 53, 112, 4),
    ("train", "USA_Lanker-2_17_T-1"): ("Lanker", 99, 78, 112, 6),
    ("val", "USA_US101-12_1_T-1"): ("US101", 81, 35, 12, 2),
}
"""City, steps, cars, lanes, scenes."""


@cache
def scenes(split: str) -> list[str]:
    return commonroad.Plugin(REAL).scenes(split)


@real
@pytest.mark.parametrize(("split", "name"), RECORDINGS)
def test_recordings_are_read_as_they_are(split: str, name: str) -> None:
    log = commonroad.Plugin(REAL).read(split, f"{name}:000")
    count = sum(scene.startswith(f"{name}:") for scene in scenes(split))
    assert (log.city, log.motion.steps, len(log.track_id), len(log.map), count) == RECORDINGS[split, name]
    assert np.isfinite(log.size[:, :2]).all()
    assert log.map.dangling == 0
    assert log.map.in_junction.any() == (log.city == "Lanker")
    scenario = select(log, SETTINGS)
    assert scenario.horizon == log.motion.steps - 1
    assert (scenario.vehicles.size_source == SizeSource.MEASURED).all()
    assert (scenario.vehicles.size > 1).all()


@real
def test_positions_are_middles_of_boxes_and_cars_drive_along_lanes() -> None:
    log = commonroad.Plugin(REAL).read("train", "USA_Lanker-2_14_T-1:000")
    motion = log.motion

    def overlaps(shift: float) -> int:
        """Pairs that overlap if the position were this share of the length behind the middle."""
        found = 0
        for t in range(0, motion.steps, 10):
            rows = np.flatnonzero(motion.valid[:, t])
            heading, size = motion.heading[rows, t], log.size[rows, :2]
            position = motion.position[rows, t] + shift * size[:, :1] * np.stack([np.cos(heading), np.sin(heading)], -1)
            every = boxes_overlap(position[:, None], heading[:, None], size[:, None], position[None], heading[None], size[None])
            found += int(every.sum() - len(rows)) // 2
        return found

    assert overlaps(0.0) < min(overlaps(-0.5), overlaps(0.5))
    moving = motion.valid & (motion.speed > 3)
    gaps = [min(abs(project(line, point)[1]) for line in log.map.centreline.lines()) for point in motion.position[moving][::151]]
    assert np.median(gaps) < 1.0
    step = np.hypot(*np.moveaxis(np.diff(motion.position, axis=1), -1, 0)) / 0.1
    assert np.median(np.abs(step - motion.speed[:, 1:])[moving[:, 1:]]) < 0.3


@cache
def recordings() -> dict[tuple[str, str], RecordedLog]:
    """All real ones by split and name."""
    paths = sorted(REAL.glob("*/*.xml"))
    return {(path.parent.name, path.stem): read_recording(path.read_bytes(), str(path), "NGSIM") for path in paths}


@real
def test_all_recordings_give_scenes_and_last_seven_seconds_but_one() -> None:
    assert len(recordings()) == 28
    assert all(spread_targets(log.kind, log.motion) for log in recordings().values())
    assert [name for (_, name), log in recordings().items() if log.motion.steps < 71] == ["USA_US101-25_1_T-1"]  # 68 steps


@real
def test_no_car_is_in_two_splits() -> None:
    """The same car at overlapping times has the same speeds, twenty in a row that are no standstill."""
    seen: dict[bytes, str] = {}
    for (split, _), log in recordings().items():
        for track in np.flatnonzero(log.motion.valid.sum(-1) >= 20):
            speed = log.motion.speed[track][log.motion.valid[track]].round(3)
            for row in sliding_window_view(speed, 20):
                if np.ptp(row) > 1.0:
                    assert seen.setdefault(row.tobytes(), split) == split


def test_what_is_no_file_or_shows_nobody_at_first_is_one_scene_with_its_reason_and_hidden_files_are_none(tmp_path: Path) -> None:
    folder = tmp_path / "train"
    (folder / "a.xml").mkdir(parents=True)
    (folder / "b.xml").symlink_to("nowhere")
    late = obstacle(5, [state(t, 1.0 + t, 0.0) for t in range(40, 90)])
    (folder / "c.xml").write_bytes(xml([*ROAD, late]))
    (folder / "._c.xml").write_bytes(b"of another system")
    data = commonroad.Plugin(tmp_path)
    assert data.scenes("train") == ["a:000", "b:000", "c:000"]
    for scene, sentence in (
        ("a:000", "a.xml cannot be read"),
        ("b:000", "b.xml cannot be read"),
        ("c:000", "no vehicle that is there"),
    ):
        with pytest.raises(UnusableInput, match=sentence):
            data.read("train", scene)


def test_a_gap_in_the_track_of_somebody_who_stands_is_no_way_driven() -> None:
    motion = row_of_cars(5)
    motion.position[0] = motion.position[0, :1]
    motion.valid[0, 80] = False
    motion.position[0, 80] = 0.0
    motion.position[:, :, 0] += 500.0
    motion.position[0, 80] = 0.0  # the filler of what is not valid
    assert 0 not in spread_targets(cars(5), motion)


def test_nobody_learns_from_a_recording_that_shows_the_cars_of_the_test_split() -> None:
    train = ["a/train/USA_US101-5_1_T-1:000", "a/train/USA_US101-3_1_T-1:000"]
    chosen = {"train": train, "val": [], "test": ["a/test/USA_US101-15_1_T-1:002"]}
    kept, shown = unseen(chosen)
    assert kept == {**chosen, "train": train[1:]}
    assert shown == {"train": train[:1], "val": [], "test": []}
