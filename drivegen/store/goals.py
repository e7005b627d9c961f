"""Shards of goals: one row a scenario's candidates and their probabilities, beside the scenario shard of the same name.

Routes are kept as the pieces of lanes that they are made of, a few numbers each; their lines are made again from the map.
What a column means is said by `goals/packing.py`, which turns candidates into columns and back.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
from numpy.typing import NDArray

from drivegen.store.lists import Shard, built, column, read_shard_table, write_shard_table

KIND = "goals"
VERSION = 2

COLUMNS: Mapping[str, pa.DataType] = {
    "candidates": pa.int32(),  # per vehicle: number of them, all vehicles' one after the other
    "position": pa.float32(),
    "heading": pa.float32(),
    "speed": pa.float32(),
    "route": pa.int32(),
    "s": pa.float32(),
    "d": pa.float32(),
    "step": pa.int32(),
    "manoeuvre": pa.uint8(),
    "lane": pa.int32(),
    "leaves_map": pa.bool_(),
    "prior": pa.float32(),
    "probability": pa.float32(),
    "place": pa.float32(),  # where it is shown: at the exit by which the vehicle leaves the map, else its position
    "leaves_after": pa.float32(),  # [s], inf where it does not
    "routes": pa.int32(),  # per vehicle
    "offset": pa.float32(),
    "ahead": pa.float64(),
    "pieces": pa.int32(),  # per route
    "piece.lane": pa.int32(),
    "piece.change": pa.int32(),
    "piece.metres": pa.float64(),
}


@dataclass(frozen=True)
class GoalColumns:
    """The goals of one scenario as flat columns (see COLUMNS) and who chose."""

    scenario_id: str
    selector: str
    columns: Mapping[str, NDArray[Any]]


def write_goals(path: Path, goals: Sequence[GoalColumns]) -> None:
    """Write goals, in order, as one file; equal goals give equal bytes."""
    table: dict[str, pa.Array] = {
        "scenario_id": pa.array([g.scenario_id for g in goals], pa.string()),
        "selector": pa.array([g.selector for g in goals], pa.string()),
    }
    table |= {name: column([g.columns[name] for g in goals], kind) for name, kind in COLUMNS.items()}
    write_shard_table(path, table, KIND, VERSION)


def read_goals(path: Path) -> list[GoalColumns]:
    """All goals of a shard, in order.

    Raises UnusableInput, naming the file, if it is not whole, not ours or of another version.
    """
    shard = read_shard_table(path, KIND, VERSION)
    return built(shard, path, _goals)


def _goals(shard: Shard, row: int) -> GoalColumns:
    return GoalColumns(shard["scenario_id"][row], shard["selector"][row], {name: shard[name][row] for name in COLUMNS})
