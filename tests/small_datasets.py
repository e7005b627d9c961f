"""Tiny data sets on disk, one builder a data set plugin; each has one scene in `train`, one broken one in `val`."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather

from drivegen.av2.export import export_scenario
from drivegen.av2.maps import write_map
from drivegen.core.scenario import Scenario
from drivegen.datasets.sumo_corpus import write_part
from tests import commonroad_files
from tests.scenes import busy_crossing

EGO_SPEED = 5.0


def argoverse2(root: Path) -> None:
    for split, name in (("train", "scene-a"), ("val", "scene-b")):
        scene = busy_crossing(60, name)
        export_scenario(scene, _log(scene), root / split, name)
    broken = next((root / "val" / "scene-b").glob("*.parquet"))
    broken.write_bytes(broken.read_bytes()[:200])


def sumo_corpus(root: Path) -> None:
    write_part(root / "train", "town-000", [busy_crossing(60, "scene-a")])
    write_part(root / "val", "hamlet-000", [busy_crossing(60, "scene-b")])
    broken = root / "val" / "tracks-hamlet-000.parquet"
    broken.write_bytes(broken.read_bytes()[:200])


def argoverse2_sensor(root: Path) -> None:
    for split in ("train", "val"):
        sensor_log(root / split / "log-a", frames=130)
    (root / "val" / "log-a" / "annotations.feather").write_bytes(b"ARROW1")


def commonroad(root: Path) -> None:
    raw = commonroad_files.xml([*commonroad_files.ROAD, *commonroad_files.CARS])
    for split, content in (("train", raw), ("val", raw[: len(raw) // 2])):
        (root / split).mkdir(parents=True)
        (root / split / "scene-a.xml").write_bytes(content)


def sensor_log(folder: Path, frames: int, lost_pose: int = -1) -> None:
    """An ego that drives north-east at 5 m/s, a car 10 m ahead of it, a parked bus, a person and a cone.

    The boxes are in the ego frame; the parked ones move backwards in it.
    """
    time = 315_000_000_000_000_000 + np.arange(frames, dtype=np.int64) * 100_000_000
    along = np.arange(frames) * 0.1 * EGO_SPEED
    pose = {"timestamp_ns": time, **_quaternion(np.full(frames, np.pi / 4)), **_offset(*(100 + along * np.sqrt(0.5),) * 2)}
    rows = [
        ("car", "REGULAR_VEHICLE", (4.5, 1.9, 1.6), np.full(frames, 10.0), np.zeros(frames)),
        ("bus", "BUS", (12.0, 2.9, 3.2), 30.0 - along, np.full(frames, -4.0)),
        ("walker", "PEDESTRIAN", (0.7, 0.7, 1.8), 20.0 - along, np.full(frames, 6.0)),
        ("cone", "CONSTRUCTION_CONE", (0.3, 0.3, 0.8), 25.0 - along, np.full(frames, 5.0)),
    ]
    boxes = [
        {
            "timestamp_ns": time,
            "track_uuid": np.full(frames, uuid),
            "category": np.full(frames, category),
            **{f"{word}_m": np.full(frames, value) for word, value in zip(("length", "width", "height"), size, strict=True)},
            **_quaternion(np.zeros(frames)),
            **_offset(x, y),
        }
        for uuid, category, size, x, y in rows
    ]
    table = {name: np.concatenate([box[name] for box in boxes]).tolist() for name in boxes[0]}
    keep = np.arange(frames) != lost_pose
    (folder / "map").mkdir(parents=True)
    pyarrow.feather.write_feather(pa.table(table), folder / "annotations.feather")
    pyarrow.feather.write_feather(pa.table({k: v[keep] for k, v in pose.items()}), folder / "city_SE3_egovehicle.feather")
    (folder / "map" / f"log_map_archive_{folder.name}____PIT_city_1.json").write_bytes(write_map(busy_crossing(2).map))


def _quaternion(yaw: np.ndarray) -> dict[str, np.ndarray]:
    return {"qw": np.cos(yaw / 2), "qx": 0 * yaw, "qy": 0 * yaw, "qz": np.sin(yaw / 2)}


def _offset(x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
    return {"tx_m": x, "ty_m": y, "tz_m": 0 * x}


def _log(scene: Scenario):
    assert scene.log is not None
    return scene.log


BUILDERS: dict[str, Callable[[Path], None]] = {
    "argoverse2": argoverse2,
    "argoverse2_sensor": argoverse2_sensor,
    "commonroad": commonroad,
    "sumo_corpus": sumo_corpus,
}
