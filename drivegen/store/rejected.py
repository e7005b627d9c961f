"""Files of trajectories that were turned down: one a method, one row a scenario, in the order in which scenes are drawn."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pyarrow as pa

from drivegen.core.rejections import Rejected
from drivegen.store.lists import Shard, built, column, read_shard_table, write_shard_table

KIND = "rejected"
VERSION = 1

_ARRAYS: dict[str, pa.DataType] = {
    "position": pa.float32(),
    "sample": pa.int32(),
    "vehicle": pa.int32(),
    "violation": pa.uint16(),
    "made_way": pa.bool_(),
}


def write_rejected(path: Path, rejected: Sequence[Rejected]) -> None:
    """Write what was turned down in some scenarios, in order, as one file; the same gives the same bytes."""
    columns: dict[str, pa.Array] = {
        "scenario_id": pa.array([one.scenario_id for one in rejected], pa.string()),
        "method": pa.array([one.method for one in rejected], pa.string()),
        "steps": pa.array([one.position.shape[1] for one in rejected], pa.int32()),
    }
    for name, kind in _ARRAYS.items():
        columns[name] = column([getattr(one, name) for one in rejected], kind)
    write_shard_table(path, columns, KIND, VERSION)


def read_rejected(path: Path) -> list[Rejected]:
    """All rows of a file, in order.

    Raises UnusableInput, naming the file, if it is not whole, not ours or of another version.
    """
    shard = read_shard_table(path, KIND, VERSION)
    return built(shard, path, _rejected)


def rejected_by_method(folder: Path) -> dict[str, dict[str, Rejected]]:
    """What the files METHOD.parquet of a folder hold, by method and scenario; nothing if there is no such folder."""
    return {file.stem: {one.scenario_id: one for one in read_rejected(file)} for file in sorted(folder.glob("*.parquet"))}


def rejected_of(scenario_id: str, by_method: Mapping[str, Mapping[str, Rejected]]) -> dict[str, Rejected]:
    """What `by_method` (see `rejected_by_method`) holds of one scenario, by method; not those of which nothing was kept."""
    return {method: scenes[scenario_id] for method, scenes in by_method.items() if scenario_id in scenes}


def _rejected(shard: Shard, row: int) -> Rejected:
    columns = {name: shard[name][row] for name in _ARRAYS}
    columns["position"] = columns["position"].reshape(-1, int(shard["steps"][row]), 2)
    return Rejected(shard["scenario_id"][row], shard["method"][row], **columns)
