"""Shards of generated futures: one row a scenario's `Samples`, in the order of the scenario shard of the same name.

Velocities are kept as they are: speed along the heading would save a fifth of the bytes, but logged and simulated motion
does not move along its heading exactly, and what is read must be what was written.
"""

from collections.abc import Sequence
from operator import attrgetter
from pathlib import Path

import pyarrow as pa

from drivegen.core.samples import Samples
from drivegen.core.scenario import Trajectories
from drivegen.store.lists import Shard, built, column, read_shard_table, write_shard_table

KIND = "samples"
VERSION = 2

_SHAPE = ("samples", "vehicles", "steps")

_ARRAYS: dict[str, pa.DataType] = {
    "motion.position": pa.float32(),
    "motion.heading": pa.float32(),
    "motion.velocity": pa.float32(),
    "motion.valid": pa.bool_(),
    "violation": pa.uint16(),
    "first_violation": pa.int16(),
    "goal": pa.int32(),
    "natural": pa.float32(),
    "used": pa.float32(),
    "attempts": pa.uint8(),
    "dropped": pa.bool_(),
    "left_map": pa.bool_(),
}


def write_samples(path: Path, samples: Sequence[Samples]) -> None:
    """Write samples, in order, as one file; equal samples give equal bytes."""
    columns: dict[str, pa.Array] = {
        "scenario_id": pa.array([s.scenario_id for s in samples], pa.string()),
        "method": pa.array([s.method for s in samples], pa.string()),
    }
    for axis, name in enumerate(_SHAPE):
        columns[name] = pa.array([s.motion.valid.shape[axis] for s in samples], pa.int32())
    for name, kind in _ARRAYS.items():
        columns[name] = column([attrgetter(name)(s) for s in samples], kind)
    write_shard_table(path, columns, KIND, VERSION)


def read_samples(path: Path) -> list[Samples]:
    """All samples of a shard, in order; their arrays are slices of one array a column.

    Raises UnusableInput, naming the file, if it is not whole, not ours or of another version.
    """
    shard = read_shard_table(path, KIND, VERSION)
    return built(shard, path, _samples)


def _samples(shard: Shard, row: int) -> Samples:
    count, vehicles, steps = (int(shard[name][row]) for name in _SHAPE)
    motion = Trajectories(
        shard["motion.position"][row].reshape(count, vehicles, steps, 2),
        shard["motion.heading"][row].reshape(count, vehicles, steps),
        shard["motion.velocity"][row].reshape(count, vehicles, steps, 2),
        shard["motion.valid"][row].reshape(count, vehicles, steps),
    )
    rest = {name: shard[name][row].reshape(count, vehicles) for name in _ARRAYS if not name.startswith("motion.")}
    return Samples(scenario_id=shard["scenario_id"][row], method=shard["method"][row], motion=motion, **rest)
