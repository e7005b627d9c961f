"""Lists to learn from on disk: one row a vehicle, a column a feature; readable with any Parquet reader."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa

from drivegen.core.errors import UnusableInput
from drivegen.goals.features import NAMES
from drivegen.goals.lists import Lists
from drivegen.store.columns import Columns
from drivegen.store.lists import list_column, read_groups, shard_writer, table_of

KIND = "goal lists"
VERSION = 1

GROUP = 2**14
"""Lists of a row group: so many are in memory at once, at most, while they are written or read."""

_FEATURE = "feature."
_OF_CANDIDATES = ("prior", "distance", "taught")


@contextmanager
def list_writer(path: Path, teacher: str = "") -> Iterator[Callable[[Lists], None]]:
    """What appends lists to a file; equal lists give equal bytes. `teacher` names whose odds are their labels, "" for logs."""
    rest = _table(Lists.none(), teacher)
    with shard_writer(path, rest.schema, KIND, VERSION) as write:
        written = 0

        def append(lists: Lists) -> None:
            nonlocal rest, written
            rest = pa.concat_tables([rest, _table(lists, teacher)])
            while rest.num_rows >= GROUP:
                write(rest.slice(0, GROUP).combine_chunks())
                rest, written = rest.slice(GROUP), written + GROUP

        yield append
        if rest.num_rows or not written:
            write(rest.combine_chunks())


def _table(lists: Lists, teacher: str) -> pa.Table:
    each = {_FEATURE + name: lists.x[:, i] for i, name in enumerate(NAMES)}
    each |= {name: getattr(lists, name) for name in _OF_CANDIDATES}
    columns = {"teacher": pa.array([teacher] * len(lists), pa.string()), "doubt": pa.array(lists.doubt, pa.float32())}
    return table_of(columns | {name: list_column(lists.start, values, pa.float32()) for name, values in each.items()})


def read_lists(path: Path, folder: Path | None = None) -> tuple[Lists, str]:
    """All lists, in order, and their teacher, "" for logs; in mapped files of `folder` where one is named.

    Raises UnusableInput, naming the file, if it is not whole, not ours or was made of other features than today's.
    """
    lists, teacher = Columns(Lists, folder), ""
    for column in read_groups(path, KIND, VERSION):
        try:
            lists.add(_lists(column))
            teacher = "".join(column("teacher")[:1].to_pylist())
        except (KeyError, ValueError) as error:
            raise UnusableInput(f"{path} holds other lists than today's ({error}): run the goal_lists stage again") from None
    return lists.whole(), teacher


def _lists(column: Callable[[str], pa.Array]) -> Lists:
    """Those of a row group. Raises KeyError or ValueError where columns are missing or of different lengths."""
    start = column("prior").offsets.to_numpy().astype(np.int64)
    x = np.empty((start[-1], len(NAMES)), np.float32)
    for i, name in enumerate(NAMES):
        x[:, i] = column(_FEATURE + name).values.to_numpy()
    rest = {name: column(name).values.to_numpy().copy() for name in _OF_CANDIDATES}
    if any(len(values) != len(x) for values in rest.values()):
        raise ValueError("columns of different lengths")
    return Lists(start=start, x=x, doubt=column("doubt").to_numpy(), **rest)
