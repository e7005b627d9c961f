"""One log of Argoverse 2 Sensor: annotated boxes and ego poses to tracks in the map's frame.

Source: argoverse/av2-api, `structures/cuboid.py`, `datasets/sensor`. Boxes are in the ego frame of their own timestamp
and `city_SE3_egovehicle` holds the pose of that frame: p_city = R(q) p_ego + t. Boxes have true sizes; there are no
velocities, so they are the slope of a line fitted to 5 positions, the last 0.4 s: none tells what comes next.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.av2.columns import checked, encoded
from drivegen.av2.maps import read_map
from drivegen.av2.schema import EGO_TRACK
from drivegen.core.errors import UnusableInput, naming
from drivegen.core.recorded_log import FARTHEST, LONGEST, expect_few_cells
from drivegen.core.roadmap import RoadMap
from drivegen.core.safe_parquet import read_feather
from drivegen.core.scenario import DT, Trajectories, VehicleKind
from drivegen.store.files import content_of

EGO_SIZE = (4.877, 2.0, 1.473)
"""Length, width, height [m] of the recording car, a Ford Fusion, as in the EGO_VEHICLE boxes that some logs have;
assumed in the logs that have none."""

EGO_CENTRE = 1.42
"""The box's centre lies this far ahead [m] of the ego frame's origin, the middle of the rear axle (half the wheelbase of
2.85 m). EGO_VEHICLE boxes stand at the origin itself and would trail the car, so the ego's motion is always its poses'."""

KIND_OF_CATEGORY = {
    "REGULAR_VEHICLE": VehicleKind.CAR,
    "LARGE_VEHICLE": VehicleKind.TRUCK,
    "TRUCK": VehicleKind.TRUCK,
    "BOX_TRUCK": VehicleKind.TRUCK,
    "TRUCK_CAB": VehicleKind.TRUCK,
    "BUS": VehicleKind.BUS,
    "SCHOOL_BUS": VehicleKind.BUS,
    "ARTICULATED_BUS": VehicleKind.BUS,
    "MOTORCYCLE": VehicleKind.MOTORCYCLE,
    "MOTORCYCLIST": VehicleKind.MOTORCYCLE,
    "BICYCLE": VehicleKind.CYCLIST,
    "BICYCLIST": VehicleKind.CYCLIST,
    "WHEELED_RIDER": VehicleKind.CYCLIST,
    "WHEELED_DEVICE": VehicleKind.CYCLIST,
    "PEDESTRIAN": VehicleKind.PEDESTRIAN,
    "OFFICIAL_SIGNALER": VehicleKind.PEDESTRIAN,
    "WHEELCHAIR": VehicleKind.PEDESTRIAN,
    "STROLLER": VehicleKind.PEDESTRIAN,
    "ANIMAL": VehicleKind.PEDESTRIAN,
    "DOG": VehicleKind.PEDESTRIAN,
}
"""Categories that move or get in the way; cones, signs, trailers and the like are skipped and counted."""

CITY_OF_CODE = {
    "ATX": "austin",
    "DTW": "dearborn",
    "MIA": "miami",
    "PAO": "palo-alto",
    "PIT": "pittsburgh",
    "WDC": "washington-dc",
}
"""City names as in Motion Forecasting, by the code in the map's file name."""

_EGO_CATEGORY = "EGO_VEHICLE"
_TIME = pa.schema([("timestamp_ns", pa.int64())])
_POSE = pa.schema([*_TIME, *((name, pa.float64()) for name in ("qw", "qx", "qy", "qz", "tx_m", "ty_m", "tz_m"))])
_SIZE = ("length_m", "width_m", "height_m")
_BOX = pa.schema(
    [*_POSE, *((name, pa.string()) for name in ("track_uuid", "category")), *((name, pa.float64()) for name in _SIZE)]
)
_PERIOD = round(DT * 1e9)
_POSE_TOLERANCE = 10_000_000
"""A pose farther than this [ns] from an annotation's timestamp is not its pose; poses come every 5 to 10 ms."""
FITTED = 5
"""Positions that a velocity is fitted to, the last of them its own."""


@dataclass(frozen=True)
class SensorLog:
    """A whole log: M tracks over T steps of 0.1 s, in the frame of `road_map`.

    Attributes:
        road_map: the log's map. city: its city.
        track_id: (M,) str, the ego is "AV". kind: (M,) uint8 VehicleKind. size: (M, 3) float32 [m].
        motion: Trajectories (M, T).
        skipped: tracks left out by category.
    """

    road_map: RoadMap
    city: str
    track_id: NDArray[np.str_]
    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    motion: Trajectories
    skipped: dict[str, int]


def log_files(folder: Path) -> tuple[Path, Path, Path]:
    """Annotations, poses and map of one log; raises UnusableInput, reason `no-such-scenario`, where one is missing."""
    patterns = ("annotations*.feather", "city_SE3_egovehicle.feather", "map/log_map_archive_*.json")
    matches = [sorted(folder.glob(pattern)) for pattern in patterns]
    for files, pattern in zip(matches, patterns, strict=True):
        if not files:
            raise UnusableInput(f"{folder} has no {pattern}; an Argoverse 2 Sensor log has one", reason="no-such-scenario")
    return matches[0][0], matches[1][0], matches[2][0]


def count_steps(folder: Path) -> int:
    """Steps of one log from its first annotated frame to its last, read from one column."""
    annotations = log_files(folder)[0]
    return int(_steps(np.unique(_read(annotations, _TIME)["timestamp_ns"].to_numpy()), annotations)[-1]) + 1


def _steps(time: NDArray[np.int64], annotations: Path) -> NDArray[np.int64]:
    """(F,) the step of each of F frames at `time` [ns], ascending; frames may be missing."""
    step = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(np.diff(time) / _PERIOD)))]).astype(np.int64)
    if len(time) == 0 or step[-1] > 100 * len(time):
        raise UnusableInput(f"{annotations} has no frames at 10 Hz", reason="no-rows")
    return step


def read_sensor_log(folder: Path) -> SensorLog:
    """The whole log. Raises UnusableInput with a countable reason, naming the file."""
    annotations, poses, archive = log_files(folder)
    road_map = read_map(content_of(archive), str(archive))
    boxes = _read(annotations, _BOX)
    (categories, category), (ids, uuid) = (_sorted(boxes[name]) for name in ("category", "track_uuid"))
    keep = np.isin(categories, list(KIND_OF_CATEGORY))[category]
    left_out = ~keep & (categories != _EGO_CATEGORY)[category]
    of_track = np.unique(category[left_out] * len(ids) + uuid[left_out]) // len(ids)
    skipped = {str(categories[i]): int(count) for i, count in zip(*np.unique(of_track, return_counts=True), strict=True)}
    time, frame = np.unique(boxes["timestamp_ns"].to_numpy(), return_inverse=True)
    step = _steps(time, annotations)
    rotation, translation = _pose_at(_read(poses, _POSE), time, str(poses))
    tracks, first_row, track = np.unique(uuid[keep], return_index=True, return_inverse=True)
    size = np.stack([boxes[name].to_numpy()[keep][first_row] for name in _SIZE], axis=-1)
    if not ((size > 0) & (size <= LONGEST)).all():
        raise UnusableInput(f"{annotations} has boxes that do not measure 0 to {LONGEST:g} m", reason="out-of-range")
    expect_few_cells(len(tracks) + 1, int(step[-1]) + 1, annotations)
    centre, forward = _in_city(boxes.filter(pa.array(keep)), rotation[frame[keep]], translation[frame[keep]])
    motion = Trajectories.empty(len(tracks) + 1, int(step[-1]) + 1)
    _place(motion, track, step[frame[keep]], centre - road_map.origin, forward, annotations)
    if np.count_nonzero(motion.valid) != len(track):
        raise UnusableInput(f"{annotations} gives a track two boxes at one time", reason="duplicate-rows")
    ego = translation[:, :2] + EGO_CENTRE * rotation[:, :2, 0]
    _place(motion, np.full(len(time), len(tracks)), step, ego - road_map.origin, rotation[:, :2, 0], poses)
    for one in range(len(motion.valid)):  # all at once would take ten times the memory of what they are
        velocity = fitted_velocity(motion.position[one], motion.valid[one])
        motion.valid[one, np.isnan(velocity[:, 0])] = False  # a track begins once its velocity is known
        motion.velocity[one] = np.nan_to_num(velocity)
    with naming(annotations):
        motion.validate()
    kind = [KIND_OF_CATEGORY[word] for word in categories[category[keep][first_row]].tolist()]
    code = archive.stem.partition("____")[2].partition("_")[0]
    return SensorLog(
        road_map=road_map,
        city=CITY_OF_CODE.get(code, code or "unknown"),
        track_id=np.append(ids[tracks], EGO_TRACK),
        kind=np.array([*kind, VehicleKind.CAR], np.uint8),
        size=np.concatenate([size, [EGO_SIZE]]).astype(np.float32),
        motion=motion,
        skipped=skipped,
    )


def fitted_velocity(position: NDArray[np.float32], valid: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Velocity (..., T, 2) [m/s]: slope of the line fitted to the valid ones among the last FITTED positions.

    NaN where there is only one of them, or none now.
    """
    reach = FITTED - 1
    weight = np.pad(valid.astype(np.float64), [*[(0, 0)] * (valid.ndim - 1), (reach, 0)])
    padded = np.pad(position.astype(np.float64), [*[(0, 0)] * (valid.ndim - 1), (reach, 0), (0, 0)])
    steps = valid.shape[-1]
    count = np.zeros(valid.shape)
    sum_t, sum_tt = count.copy(), count.copy()
    sum_x, sum_tx = np.zeros(position.shape), np.zeros(position.shape)
    for offset in range(-reach, 1):
        window = slice(offset + reach, offset + reach + steps)
        w, x = weight[..., window], padded[..., window, :]
        count += w
        sum_t += w * offset
        sum_tt += w * offset**2
        sum_x += w[..., None] * x
        sum_tx += (w * offset)[..., None] * x
    spread = count * sum_tt - sum_t**2
    slope = (count[..., None] * sum_tx - sum_t[..., None] * sum_x) / np.maximum(spread, 1.0)[..., None]
    return np.where((spread > 0)[..., None] & valid[..., None], slope / DT, np.nan).astype(np.float32)


def _read(path: Path, columns: pa.Schema) -> pa.Table:
    try:
        table = read_feather(path, columns.names)
    except (pa.ArrowException, OSError) as error:
        what = str(error).splitlines()[0]
        raise UnusableInput(f"{path} is no whole Feather file ({what}): copy it again", reason="truncated") from None
    return checked(table, columns, path).combine_chunks()


def _sorted(column: pa.ChunkedArray) -> tuple[NDArray[np.str_], NDArray[np.int64]]:
    """Different words in the order of the alphabet, and each row's number of them."""
    words, code = encoded(column)
    words, number = np.unique(words, return_inverse=True)
    return words, number[code]


def _rotation(table: pa.Table) -> NDArray[np.float64]:
    """Rotation matrices (R, 3, 3) of the quaternions (w, x, y, z), which need not be of unit length."""
    quaternion = np.stack([table[name].to_numpy() for name in ("qw", "qx", "qy", "qz")]).astype(np.float64)
    length = np.sqrt((quaternion**2).sum(0))
    w, x, y, z = np.divide(quaternion, length, where=length > 0, out=np.full_like(quaternion, np.nan))
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def _translation(table: pa.Table) -> NDArray[np.float64]:
    return np.stack([table[name].to_numpy() for name in ("tx_m", "ty_m", "tz_m")], axis=-1).astype(np.float64)


def _pose_at(poses: pa.Table, time: NDArray[np.int64], place: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rotations (F, 3, 3) and translations (F, 3) of the ego at `time` (F,) [ns]: the pose of that timestamp."""
    poses = poses.sort_by("timestamp_ns")
    times = poses["timestamp_ns"].to_numpy()
    after = np.clip(np.searchsorted(times, time), 1, max(1, len(times) - 1))
    nearest = np.where(time - times[after - 1] <= np.abs(times[np.minimum(after, len(times) - 1)] - time), after - 1, after)
    nearest = np.minimum(nearest, len(times) - 1)
    if np.abs(times[nearest] - time).max() > _POSE_TOLERANCE:
        raise UnusableInput(f"{place} lacks the pose of an annotated frame", reason="missing-poses")
    return _rotation(poses)[nearest], _translation(poses)[nearest]


def _in_city(
    boxes: pa.Table, rotation: NDArray[np.float64], translation: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres and forward directions (R, 2) of boxes in city coordinates, given the ego's pose (R, ...) for each row."""
    centre = np.einsum("rij,rj->ri", rotation, _translation(boxes)) + translation
    forward = np.einsum("rij,rj->ri", rotation, _rotation(boxes)[:, :, 0])
    return centre[:, :2], forward[:, :2]


def _place(
    motion: Trajectories,
    track: NDArray[np.integer],
    step: NDArray[np.int64],
    position: NDArray[np.float64],
    forward: NDArray[np.float64],
    place: Path,
) -> None:
    if not np.abs(position).max(initial=0) <= FARTHEST:
        raise UnusableInput(f"{place} has positions more than {FARTHEST / 1000:g} km off its map", reason="out-of-range")
    motion.position[track, step] = position
    motion.heading[track, step] = np.arctan2(forward[:, 1], forward[:, 0])
    motion.valid[track, step] = True
