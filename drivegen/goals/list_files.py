"""Lists to learn from on disk: one row a vehicle, a column a feature, without padding; readable with any Parquet reader."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from drivegen.core.errors import UnusableInput
from drivegen.goals.candidates import MOST
from drivegen.goals.features import NAMES
from drivegen.goals.lists import Lists
from drivegen.store.lists import column, read_shard_table, write_shard_table

KIND = "goal lists"
VERSION = 1

_FEATURE = "feature."
_OF_CANDIDATES = ("prior", "distance", "taught")


def write_lists(path: Path, lists: Lists, teacher: str = "") -> None:
    """Write all lists, in order; equal lists give equal bytes. `teacher` names whose odds they are labelled with, "" for logs."""
    there = np.isfinite(lists.distance)
    ends = np.cumsum(there.sum(1))[:-1]
    each = {_FEATURE + name: lists.x[..., i] for i, name in enumerate(NAMES)}
    each |= {name: getattr(lists, name) for name in _OF_CANDIDATES}
    table: dict[str, pa.Array] = {
        "teacher": pa.array([teacher] * len(lists), pa.string()),
        "doubt": pa.array(lists.doubt, pa.float32()),
    }
    table |= {name: column(np.split(values[there], ends) if len(lists) else [], pa.float32()) for name, values in each.items()}
    write_shard_table(path, table, KIND, VERSION)


def read_lists(path: Path) -> tuple[Lists, str]:
    """All lists, in order, and their teacher, "" for logs.

    Raises UnusableInput, naming the file, if it is not whole, not ours or was made of other features than today's.
    """
    shard = read_shard_table(path, KIND, VERSION)
    if shard.count == 0:
        return Lists.none(), ""
    try:
        counts = np.array([len(row) for row in shard["prior"]])
        there = np.arange(MOST) < counts[:, None]
        x = np.zeros((shard.count, MOST, len(NAMES)), np.float32)
        for i, name in enumerate(NAMES):
            x[there, i] = np.concatenate(shard[_FEATURE + name])
        tables = {name: np.zeros(there.shape, np.float32) for name in _OF_CANDIDATES}
        tables["distance"][~there] = np.inf
        for name, table in tables.items():
            table[there] = np.concatenate(shard[name])
        doubt = np.asarray(shard["doubt"], np.float32)
    except (KeyError, ValueError) as error:
        raise UnusableInput(f"{path} holds other lists than today's ({error}): run the goal_lists stage again") from None
    return Lists(x=x, doubt=doubt, **tables), str(shard["teacher"][0])
