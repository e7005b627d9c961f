"""Shards of scenarios: one row a scenario, `shard-00000.parquet`, ... in a folder. The record of the pipeline.

Columns are named after the fields of `Scenario`, with a dot for parts: `vehicles.size`, `map.centreline.points`. Arrays
are flat; their shapes follow from the number of vehicles, lanes and so on.
"""

from collections.abc import Callable, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import Polylines
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import Actors, Scenario, Trajectories, Vehicles
from drivegen.core.signals import Signals
from drivegen.store.lists import Shard, built, column, read_shard_table, write_shard_table

KIND = "scenarios"
VERSION = 4

_BOOL, _BYTE, _INT, _LONG = pa.bool_(), pa.uint8(), pa.int32(), pa.int64()
_FLOAT, _DOUBLE, _WORD = pa.float32(), pa.float64(), pa.string()

_MOTION = {"position": _FLOAT, "heading": _FLOAT, "velocity": _FLOAT, "valid": _BOOL}
_LINES = {"points": _FLOAT, "start": _INT}
_LINE_LAYERS = ("centreline", "left", "right", "drivable", "crossings")

_ARRAYS: dict[str, pa.DataType] = {
    "map.origin": _DOUBLE,
    "map.lane_id": _LONG,
    "map.kind": _BYTE,
    "map.speed_limit": _FLOAT,
    "map.in_junction": _BOOL,
    "map.control": _BYTE,
    "map.links": _INT,
    "map.yields_to": _INT,
    "map.neighbour": _INT,
    "map.same_direction": _BOOL,
    "map.may_change": _BOOL,
    "map.cut": _BOOL,
    "map.stop_lines": _FLOAT,
    "map.stop_lane": _INT,
    **{f"map.{layer}.{part}": kind for layer in _LINE_LAYERS for part, kind in _LINES.items()},
    "vehicles.track_id": _WORD,
    "vehicles.kind": _BYTE,
    "vehicles.size": _FLOAT,
    "vehicles.size_source": _BYTE,
    "vehicles.position": _FLOAT,
    "vehicles.heading": _FLOAT,
    "vehicles.speed": _FLOAT,
    "context.track_id": _WORD,
    "context.kind": _BYTE,
    "context.size": _FLOAT,
    **{f"context.motion.{part}": kind for part, kind in _MOTION.items()},
    "signals.lane": _INT,
    "signals.state": _BYTE,
}
"""List columns that every scenario has."""

_LOG_ARRAYS = {f"log.{part}": kind for part, kind in _MOTION.items()}
"""List columns that are empty where there is no log."""

_SCALARS: dict[str, tuple[pa.DataType, Callable[[Scenario], Any]]] = {
    "scenario_id": (_WORD, attrgetter("scenario_id")),
    "source": (_WORD, attrgetter("source")),
    "city": (_WORD, attrgetter("city")),
    "horizon": (_INT, attrgetter("horizon")),
    "has_log": (_BOOL, lambda scenario: scenario.log is not None),
    "per_hour": (_DOUBLE, attrgetter("per_hour")),
    "map.dangling": (_INT, attrgetter("map.dangling")),
    "notes": (_WORD, lambda scenario: orjson.dumps(scenario.notes, option=orjson.OPT_SORT_KEYS).decode()),
}


def shards(folder: Path) -> list[Path]:
    """All shards in a folder, in order; empty if there are none."""
    return sorted(folder.glob("shard-*.parquet"))


def write_shard(path: Path, scenarios: Sequence[Scenario]) -> None:
    """Write scenarios, in order, as one file; equal scenarios give equal bytes."""
    columns: dict[str, pa.Array] = {
        name: pa.array([read(scenario) for scenario in scenarios], kind) for name, (kind, read) in _SCALARS.items()
    }
    for name, kind in _ARRAYS.items():
        read = attrgetter(name)
        columns[name] = column([read(scenario) for scenario in scenarios], kind)
    for name, kind in _LOG_ARRAYS.items():
        read = attrgetter(name)
        columns[name] = column([read(s) if s.log is not None else np.zeros(0, np.bool_) for s in scenarios], kind)
    write_shard_table(path, columns, KIND, VERSION)


def read_shard(path: Path) -> list[Scenario]:
    """All scenarios of a shard, in order; their arrays are slices of one array a column.

    Raises UnusableInput, naming the file, if it is not whole, not ours or of another version.
    """
    shard = read_shard_table(path, KIND, VERSION)
    return built(shard, path, _scenario)


def count(path: Path) -> int:
    """Scenarios of a shard, by its footer alone. Raises UnusableInput, naming the file, if it is not whole."""
    try:
        return int(pq.read_metadata(path).num_rows)
    except (pa.ArrowException, OSError) as error:
        what = str(error).splitlines()[0]
        raise UnusableInput(f"{path} is no whole shard ({what}): make it again", reason="truncated") from None


def _scenario(shard: Shard, row: int) -> Scenario:
    steps = int(shard["horizon"][row]) + 1
    vehicles = Vehicles(
        track_id=_words(shard["vehicles.track_id"][row]),
        kind=shard["vehicles.kind"][row],
        size=shard["vehicles.size"][row].reshape(-1, 3),
        size_source=shard["vehicles.size_source"][row],
        position=shard["vehicles.position"][row].reshape(-1, 2),
        heading=shard["vehicles.heading"][row],
        speed=shard["vehicles.speed"][row],
    )
    context = Actors(
        track_id=_words(shard["context.track_id"][row]),
        kind=shard["context.kind"][row],
        size=shard["context.size"][row].reshape(-1, 3),
        motion=_motion(shard, "context.motion", row, steps),
    )
    scenario = Scenario(
        scenario_id=shard["scenario_id"][row],
        source=shard["source"][row],
        city=shard["city"][row],
        map=_map(shard, row),
        vehicles=vehicles,
        horizon=steps - 1,
        log=_motion(shard, "log", row, steps) if shard["has_log"][row] else None,
        context=context,
        signals=Signals(shard["signals.lane"][row], shard["signals.state"][row].reshape(-1, steps)),
        notes=orjson.loads(shard["notes"][row]),
        per_hour=float(shard["per_hour"][row]),
    )
    scenario.validate()
    return scenario


def _map(shard: Shard, row: int) -> RoadMap:
    lines = {
        layer: Polylines(shard[f"map.{layer}.points"][row].reshape(-1, 2), shard[f"map.{layer}.start"][row])
        for layer in _LINE_LAYERS
    }
    return RoadMap(
        origin=shard["map.origin"][row],
        lane_id=shard["map.lane_id"][row],
        kind=shard["map.kind"][row],
        speed_limit=shard["map.speed_limit"][row],
        in_junction=shard["map.in_junction"][row],
        control=shard["map.control"][row],
        links=shard["map.links"][row].reshape(-1, 2),
        yields_to=shard["map.yields_to"][row].reshape(-1, 2),
        neighbour=shard["map.neighbour"][row].reshape(-1, 2),
        same_direction=shard["map.same_direction"][row].reshape(-1, 2),
        may_change=shard["map.may_change"][row].reshape(-1, 2),
        cut=shard["map.cut"][row].reshape(-1, 2),
        stop_lines=shard["map.stop_lines"][row].reshape(-1, 2, 2),
        stop_lane=shard["map.stop_lane"][row],
        dangling=shard["map.dangling"][row],
        **lines,
    )


def _motion(shard: Shard, name: str, row: int, steps: int) -> Trajectories:
    return Trajectories(
        position=shard[f"{name}.position"][row].reshape(-1, steps, 2),
        heading=shard[f"{name}.heading"][row].reshape(-1, steps),
        velocity=shard[f"{name}.velocity"][row].reshape(-1, steps, 2),
        valid=shard[f"{name}.valid"][row].reshape(-1, steps),
    )


def _words(words: list[str]) -> NDArray[np.str_]:
    return np.array(words, np.str_)
