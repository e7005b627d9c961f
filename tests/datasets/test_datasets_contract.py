"""What every data set plugin keeps to; a new one adds a builder of a tiny data set to `tests/small_datasets.py`."""

from pathlib import Path

import numpy as np
import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import NO_TRACK
from drivegen.datasets.base import Dataset, id_of
from drivegen.ingest.selection import Settings, select
from drivegen.ingest.vehicles import PLANNED_KINDS
from tests.small_datasets import BUILDERS

NAMES = plugins.names("datasets")
SETTINGS = Settings(target="focal", max_vehicles=16, first_step=0, horizon=100, map_radius=None, smallest_shrink=0.8)


@pytest.fixture
def opened(name: str, tmp_path: Path) -> Dataset:
    assert name in BUILDERS, f"add a builder for {name!r} to tests/small_datasets.py"
    BUILDERS[name](tmp_path)
    return plugins.load("datasets", name)(tmp_path)


@pytest.mark.parametrize("name", NAMES)
def test_it_describes_itself(name: str, opened: Dataset) -> None:
    assert opened.description
    assert ("simulated" in opened.description) == (name == "sumo_corpus")


@pytest.mark.parametrize("name", NAMES)
def test_scenes_are_sorted_distinct_and_absent_where_there_are_none(name: str, opened: Dataset) -> None:
    scenes = opened.scenes("train")
    assert scenes == sorted(set(scenes))
    assert scenes
    assert opened.scenes("test") == []


@pytest.mark.parametrize("name", NAMES)
def test_a_recording_is_sound_and_in_a_local_frame(name: str, opened: Dataset) -> None:
    log = opened.read("train", opened.scenes("train")[0])
    log.map.validate()
    log.motion.validate()
    count, steps = log.motion.valid.shape
    assert len(log.track_id) == len(log.kind) == len(log.size) == count
    assert len(set(log.track_id.tolist())) == count
    assert log.motion.valid.any(-1).all()
    assert log.signals.state.shape == (len(log.signals), steps)
    assert np.abs(log.map.centreline.points).max() < 50_000
    for track in (log.focal, log.ego):
        assert track == NO_TRACK or 0 <= track < count
    assert log.source == opened.description
    assert log.scenario_id == id_of(opened.scenes("train")[0])


@pytest.mark.parametrize("name", NAMES)
def test_a_recording_becomes_a_scenario(name: str, opened: Dataset) -> None:
    scenario = select(opened.read("train", opened.scenes("train")[0]), SETTINGS)
    scenario.validate()
    assert scenario.log is not None
    assert scenario.log.valid[:, 0].all()
    assert np.hypot(*scenario.vehicles.position[0]) < 1.0
    assert np.isin(scenario.vehicles.kind, PLANNED_KINDS).all()


@pytest.mark.parametrize("name", NAMES)
def test_reading_twice_gives_the_same(name: str, opened: Dataset) -> None:
    scene = opened.scenes("train")[0]
    one, two = opened.read("train", scene), plugins.load("datasets", name)(_root(opened)).read("train", scene)
    np.testing.assert_array_equal(one.motion.position, two.motion.position)
    np.testing.assert_array_equal(one.track_id, two.track_id)


def _root(opened: Dataset) -> Path:
    file = opened.files("train", opened.scenes("train")[0])[0]
    return next(folder.parent for folder in file.parents if folder.name == "train")


@pytest.mark.parametrize("name", NAMES)
def test_it_names_the_files_that_a_scene_is_read_from(name: str, opened: Dataset) -> None:
    files = opened.files("train", opened.scenes("train")[0])
    assert files
    assert all(file.is_file() for file in files)


@pytest.mark.parametrize("name", NAMES)
def test_a_broken_file_is_refused_with_a_countable_reason(name: str, opened: Dataset) -> None:
    with pytest.raises(UnusableInput) as caught:
        opened.read("val", opened.scenes("val")[0])
    assert caught.value.reason == "truncated"
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_that_is_not_there_is_refused(name: str, opened: Dataset) -> None:
    with pytest.raises(UnusableInput):
        opened.read("train", "no-such-scene")


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_that_is_not_there_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match="nowhere"):
        plugins.load("datasets", name)(tmp_path / "nowhere")
