"""Real recordings: the known traits of the files in ../shared/data (or $DRIVEGEN_REAL_DATA) come out as they are."""

import os
from pathlib import Path

import numpy as np
import pytest

from drivegen.av2.export import export_scenario
from drivegen.av2.folder import read_folder
from drivegen.core.geometry import project
from drivegen.core.roadmap import LaneKind
from drivegen.core.scenario import SizeSource, VehicleKind
from drivegen.datasets import argoverse2, argoverse2_sensor
from drivegen.ingest.selection import Settings, select

REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[2].parent / "shared" / "data")) / "argoverse2"
FORECASTING, SENSOR = REAL / "motion-forecasting", REAL / "sensor"
SETTINGS = Settings(target="focal", max_vehicles=16, first_step=0, horizon=100, map_radius=None, smallest_shrink=0.8)

pytestmark = pytest.mark.skipif(not REAL.is_dir(), reason=f"no real Argoverse 2 data in {REAL}")

SCENES = {
    "0a0a2bb7": ("train", "pittsburgh", 110, 53, 19),
    "0a1e6f0a": ("train", "austin", 110, 71, 17),
    "00a0ec58": ("val", "washington-dc", 110, 63, 21),
    "0a0af725": ("test", "austin", 50, 134, 31),
}
"""Split, city, steps, lanes, links to lanes that the cropped map lacks."""


def forecasting(prefix: str):
    data = argoverse2.Plugin(FORECASTING)
    split = SCENES[prefix][0]
    return data.read(split, next(scene for scene in data.scenes(split) if scene.startswith(prefix)))


@pytest.mark.parametrize("prefix", SCENES)
def test_forecasting_scenes_are_read_as_they_are(prefix: str) -> None:
    log = forecasting(prefix)
    _, city, steps, lanes, dangling = SCENES[prefix]
    assert (log.city, log.motion.steps, len(log.map), log.map.dangling) == (city, steps, lanes, dangling)
    assert np.isnan(log.size).all()
    assert len(log.signals) == 0
    assert log.track_id[log.ego] == "AV"
    assert log.motion.valid[log.focal].all()


def test_tracks_lie_on_lanes_and_move_as_fast_as_their_velocities_say() -> None:
    log = forecasting("00a0ec58")
    target = log.motion[log.focal]
    lines = [line for line, kind in zip(log.map.centreline.lines(), log.map.kind, strict=True) if kind != LaneKind.BIKE]
    gaps = [min(abs(project(line, point)[1]) for line in lines) for point in target.position[::10]]
    assert np.median(gaps) < 1.0
    travelled = np.hypot(*np.diff(target.position, axis=0).T).sum()
    assert travelled == pytest.approx(target.speed[:-1].sum() * 0.1, rel=0.03)


def test_a_focal_cyclist_makes_way_for_the_av_and_it_is_noted() -> None:
    log = forecasting("0a0a2bb7")
    scenario = select(log, SETTINGS)
    assert log.kind[log.focal] == VehicleKind.CYCLIST
    assert scenario.vehicles.track_id[0] == "AV"
    assert scenario.notes["target"] == "AV, because the focal track is no vehicle"
    assert log.track_id[log.focal] in scenario.context.track_id


def test_fifty_steps_are_a_shorter_horizon() -> None:
    scenario = select(forecasting("0a0af725"), SETTINGS)
    assert scenario.horizon == 49
    assert scenario.log is not None
    assert scenario.log.steps == 50


def test_sizes_are_assumed_and_said_to_be() -> None:
    scenario = select(forecasting("0a1e6f0a"), SETTINGS)
    assert (scenario.vehicles.size_source == SizeSource.ASSUMED).all()


def test_an_overlap_of_moving_boxes_in_the_first_frame_drops_the_farther_one() -> None:
    scenario = select(forecasting("00a0ec58"), SETTINGS)
    assert scenario.notes["dropped_overlapping"] == "1"
    assert len(scenario.vehicles) == 16


def test_a_real_scenario_survives_export_and_reading(tmp_path: Path) -> None:
    scenario = select(forecasting("0a1e6f0a"), SETTINGS)
    assert scenario.log is not None
    again = select(read_folder(export_scenario(scenario, scenario.log, tmp_path, "real"), scenario.source), SETTINGS)
    assert again.log is not None
    np.testing.assert_array_equal(again.vehicles.track_id, scenario.vehicles.track_id)
    np.testing.assert_array_equal(again.log.valid, scenario.log.valid)
    np.testing.assert_array_equal(again.log.position, scenario.log.position)
    np.testing.assert_array_equal(again.map.links, scenario.map.links)
    np.testing.assert_array_equal(again.map.may_change, scenario.map.may_change)
    np.testing.assert_allclose(again.map.centreline.points, scenario.map.centreline.points, atol=1e-3)


def test_sensor_logs_are_windows_with_true_boxes_around_the_ego() -> None:
    data = argoverse2_sensor.Plugin(SENSOR)
    scenes = data.scenes("train")
    assert len(scenes) == 6
    for scene in (scenes[0], scenes[3]):
        log = data.read("train", scene)
        scenario = select(log, SETTINGS)
        assert log.city in ("miami", "pittsburgh")
        assert log.motion.steps == 110
        assert np.isfinite(log.size).all()
        assert (scenario.vehicles.size_source == SizeSource.MEASURED).all()
        assert scenario.vehicles.track_id[0] == "AV"
        assert {"BOLLARD", "CONSTRUCTION_CONE"} <= set(log.skipped)


def test_moving_sensor_vehicles_drive_along_lanes_and_ahead() -> None:
    log = argoverse2_sensor.Plugin(SENSOR).read("train", argoverse2_sensor.Plugin(SENSOR).scenes("train")[0])
    moving = (log.motion.speed > 2) & log.motion.valid & (log.kind <= VehicleKind.BUS)[:, None]
    position, heading, velocity = (a[moving][::97] for a in (log.motion.position, log.motion.heading, log.motion.velocity))
    ahead = (np.stack([np.cos(heading), np.sin(heading)], -1) * velocity).sum(-1) / np.hypot(*velocity.T)
    assert np.median(ahead) > 0.99
    gaps = [min(abs(project(line, point)[1]) for line in log.map.centreline.lines()) for point in position]
    assert np.median(gaps) < 1.2
