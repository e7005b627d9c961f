"""Argoverse 2 Motion Forecasting tracks: the official table of one row per track and time step, to and from arrays.

Reading scatters whole columns into dense (M, T) arrays: no object per time step (28 ms per scenario in av2, 1 to 2 ms
here). Positions in files are city coordinates, in memory the map's local ones.
"""

from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from drivegen.av2.columns import checked, encoded, is_number
from drivegen.av2.schema import (
    COLUMNS,
    CONSTANTS,
    EGO_TRACK,
    KIND_OF_TYPE,
    NUMBERS,
    OBSERVED_STEPS,
    REQUIRED,
    SIZE_COLUMNS,
    TRUCK,
    TRUCK_LENGTH,
    TYPE_OF_KIND,
    TrackCategory,
)
from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import wrap_angle
from drivegen.core.recorded_log import FARTHEST, LONGEST, MOST_CELLS, NO_TRACK, RecordedLog, expect_few_cells
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories, VehicleKind
from drivegen.core.signals import Signals

FASTEST = 10_000.0
"""Velocities beyond this [m/s] are a broken file; what no vehicle can do is left to `selection`."""


def read_log(tracks: pa.Table, road_map: RoadMap, source: str, place: str, signals: Signals | None = None) -> RecordedLog:
    """All tracks of one recording as dense arrays, in the map's frame.

    Args:
        tracks: the official columns (`schema.REQUIRED` at least; `length`, `width`, `height` [m] and `truck` are used if there).
        road_map: map of the recording; its origin is subtracted from the positions.
        source: data set in words.
        place: the file's name for error sentences.
        signals: states over at least as many steps as the tracks have; none if absent.

    T is one more than the last time step found: `num_timestamps` is wrong in files whose future is withheld.
    Raises UnusableInput with a reason of `columns.checked`, `mixed-scenarios`, `duplicate-rows` or `no-tracks`, naming `place`.
    """
    tracks = _checked(tracks, place)
    step = tracks["timestep"].to_numpy()
    track_id, track = encoded(tracks["track_id"])
    steps = int(step.max()) + 1
    expect_few_cells(len(track_id), steps, place)
    first_row = np.zeros(len(track_id), np.int64)
    first_row[track[::-1]] = np.arange(len(track))[::-1]
    type_word, type_code = encoded(tracks["object_type"])
    object_type = type_word[type_code[first_row]]
    kind = np.array([KIND_OF_TYPE.get(word, -1) for word in object_type.tolist()], np.int16)
    keep = kind >= 0
    if not keep.any():
        raise UnusableInput(f"{place} holds no vehicle and nobody on foot or bicycle", reason="no-tracks")
    skipped = {word: int(np.count_nonzero(object_type[~keep] == word)) for word in sorted(set(object_type[~keep].tolist()))}
    motion = _dense(tracks, track, step, (len(track_id), steps), road_map.origin, place)
    size = _sizes(tracks, first_row)
    kind[(kind == VehicleKind.CAR) & _trucks(tracks, first_row, size)] = VehicleKind.TRUCK
    constant = {name: tracks[name][0].as_py() for name in CONSTANTS}
    return RecordedLog(
        scenario_id=constant["scenario_id"],
        source=source,
        city=constant["city"],
        map=road_map,
        track_id=track_id[keep],
        kind=kind[keep].astype(np.uint8),
        size=size[keep],
        motion=motion[keep],
        focal=_row(track_id[keep], constant["focal_track_id"]),
        ego=_row(track_id[keep], EGO_TRACK),
        signals=_lasting(signals, steps),
        skipped=skipped,
    )


def _checked(tracks: pa.Table, place: str) -> pa.Table:
    """The columns we read, proved to be sound and of one scenario, and steps that are not absurd."""
    tracks = checked(tracks, pa.schema([COLUMNS.field(name) for name in REQUIRED]), place, (*SIZE_COLUMNS, TRUCK))
    low, high = pc.min_max(tracks["timestep"]).as_py().values()
    if low < 0 or high >= MOST_CELLS:
        raise UnusableInput(f"{place}: time steps run from {low} to {high}", reason="out-of-range")
    for name in CONSTANTS:
        if (count := len(tracks[name].unify_dictionaries().unique())) > 1:
            said = f"{place}: column {name} has {count} values, and a file holds one scenario: give each a file of its own"
            raise UnusableInput(said, reason="mixed-scenarios")
    return tracks


def _dense(
    tracks: pa.Table,
    track: NDArray[np.int64],
    step: NDArray[np.int64],
    shape: tuple[int, int],
    origin: NDArray[np.float64],
    place: str,
) -> Trajectories:
    columns = {name: tracks[name].to_numpy() for name in NUMBERS}
    motion = Trajectories.empty(*shape)
    cell = track * shape[1] + step
    valid, heading = motion.valid.reshape(-1), motion.heading.reshape(-1)
    position, velocity = motion.position.reshape(-1, 2), motion.velocity.reshape(-1, 2)
    valid[cell] = True
    if np.count_nonzero(valid) != len(cell):
        raise UnusableInput(f"{place} gives a track two states at one time step", reason="duplicate-rows")
    heading[cell] = wrap_angle(columns["heading"])
    for axis, name in enumerate("xy"):
        local = columns[f"position_{name}"] - origin[axis]
        if np.abs(local).max() > FARTHEST:
            raise UnusableInput(f"{place} has positions more than {FARTHEST / 1000:g} km off its map", reason="out-of-range")
        if np.abs(columns[f"velocity_{name}"]).max() > FASTEST:
            raise UnusableInput(f"{place} has velocities beyond {FASTEST:g} m/s", reason="out-of-range")
        position[cell, axis] = local
        velocity[cell, axis] = columns[f"velocity_{name}"]
    return motion


def _sizes(tracks: pa.Table, first_row: NDArray[np.int64]) -> NDArray[np.float32]:
    """Length, width, height (M, 3) [m] from each track's first row; NaN where there is no usable number.

    Flat recordings have no heights; length and width are there together or not at all.
    """
    size = np.full((len(first_row), 3), np.nan, np.float32)
    for axis, name in enumerate(SIZE_COLUMNS):
        if name in tracks.column_names and is_number(tracks.schema.field(name).type):
            size[:, axis] = tracks[name].to_numpy()[first_row]
    size[~((size > 0) & (size <= LONGEST))] = np.nan
    size[np.isnan(size[:, :2]).any(-1)] = np.nan
    return size


def _trucks(tracks: pa.Table, first_row: NDArray[np.int64], size: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(M,) whether each track would be a truck as a `vehicle`: by our column where it is there, else by its length."""
    if TRUCK in tracks.column_names and pa.types.is_boolean(tracks.schema.field(TRUCK).type) and not tracks[TRUCK].null_count:
        return np.asarray(tracks[TRUCK].to_numpy()[first_row], np.bool_)
    return np.asarray(size[:, 0] > TRUCK_LENGTH)


def _row(track_id: NDArray[np.str_], name: str) -> int:
    rows = np.flatnonzero(track_id == name)
    return int(rows[0]) if len(rows) else NO_TRACK


def _lasting(signals: Signals | None, steps: int) -> Signals:
    """The signals over exactly `steps` steps; what the file does not say is UNKNOWN (0)."""
    if signals is None:
        return Signals.none(steps)
    missing = max(0, steps - signals.state.shape[1])
    return Signals(signals.lane, np.pad(signals.state[:, :steps], ((0, 0), (0, missing))))


def track_table(scenario: Scenario, motion: Trajectories, scenario_id: str) -> pa.Table:
    """The official table of a scenario's vehicles moving by `motion` (N, T) and of its context actors.

    Only valid states have rows, track by track. Vehicle 0 is the focal track; a track seen at every step is scored if
    it is a vehicle's; positions are in city coordinates; time begins at 0 ns.
    """
    vehicles, context = scenario.vehicles, scenario.context
    track_id = np.concatenate([vehicles.track_id, context.track_id])
    kind = np.concatenate([vehicles.kind, context.kind])
    size = np.concatenate([vehicles.size, context.size])
    valid = np.concatenate([motion.valid, context.motion.valid])
    track, step = np.nonzero(valid)

    def rows(ours: NDArray[Any], theirs: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([ours, theirs])[track, step].astype(np.float64)

    position = rows(motion.position, context.motion.position) + scenario.map.origin
    velocity = rows(motion.velocity, context.motion.velocity)
    types = np.array([TYPE_OF_KIND[VehicleKind(int(k))] for k in kind], np.str_)
    columns: dict[str, Any] = {
        "observed": step < OBSERVED_STEPS,
        "track_id": _words(track_id, track),
        "object_type": _words(types, track),
        "object_category": _categories(valid, len(vehicles))[track],
        "timestep": step,
        "position_x": position[:, 0],
        "position_y": position[:, 1],
        "heading": rows(motion.heading, context.motion.heading),
        "velocity_x": velocity[:, 0],
        "velocity_y": velocity[:, 1],
        "scenario_id": scenario_id,
        "start_timestamp": 0.0,
        "end_timestamp": round((scenario.steps - 1) * DT * 1e9),
        "num_timestamps": scenario.steps,
        "focal_track_id": str(vehicles.track_id[TARGET]),
        "city": scenario.city,
        **{name: size[track, axis] for axis, name in enumerate(SIZE_COLUMNS)},
        TRUCK: (kind == VehicleKind.TRUCK)[track],
    }
    arrays = [_column(columns[field.name], field.type, len(track)) for field in COLUMNS]
    return pa.Table.from_arrays(arrays, schema=COLUMNS)


def _categories(valid: NDArray[np.bool_], vehicles: int) -> NDArray[np.int64]:
    category = np.full(len(valid), TrackCategory.UNSCORED, np.int64)
    category[:vehicles] = TrackCategory.SCORED
    category[~valid.all(-1)] = TrackCategory.FRAGMENT
    category[TARGET] = TrackCategory.FOCAL
    return category


def _words(words: NDArray[np.str_], rows: NDArray[np.intp]) -> pa.Array:
    return pa.array(words.tolist(), pa.string()).take(pa.array(rows))


def _column(values: Any, kind: pa.DataType, count: int) -> pa.Array:
    if isinstance(values, pa.Array):
        return values
    if isinstance(values, np.ndarray):
        return pa.array(values).cast(kind)
    return pa.repeat(pa.scalar(values, kind), count)
