"""Shards: one Parquet file of a few hundred rows, whose columns are lists of numbers; arrays in and out, no row objects.

A column of a shard is one array of all rows' numbers, end to end, with the rows' offsets: writing concatenates, reading
slices. Floats are stored as byte streams (Parquet's BYTE_STREAM_SPLIT), which zstd packs far better than whole floats.
Same content, same bytes; the schema's version and a checksum of the whole file stand in it and are checked.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput, naming
from drivegen.core.safe_parquet import open_parquet
from drivegen.core.seal import BLANK, expect_seal, has_seal, seal_file
from drivegen.store.files import whole

_KIND = b"drivegen"
_VERSION = b"drivegen.version"
_AGAIN = "run the stage that made it again"

Row = TypeVar("Row")


class Shard:
    """A shard that was read: `shard["map.links"][i]` is row i of a column, flat; strings are lists."""

    def __init__(self, table: pa.Table) -> None:
        self._columns = {name: _rows(table[name]) for name in table.column_names}
        self.count = table.num_rows

    def __getitem__(self, column: str) -> Any:
        return self._columns[column]


def column(rows: Sequence[NDArray[Any]], kind: pa.DataType) -> pa.Array:
    """A list column from one array of any shape per row, flattened."""
    start = np.cumsum([0, *(row.size for row in rows)]).astype(np.int32)
    if pa.types.is_string(kind):
        values = pa.array([word for row in rows for word in row.tolist()], kind)
    else:
        values = pa.array(np.concatenate([row.ravel() for row in rows]) if rows else np.zeros(0)).cast(kind)
    return pa.ListArray.from_arrays(start, values, type=_list_of(kind))


def list_column(start: NDArray[np.integer], values: NDArray[Any], kind: pa.DataType) -> pa.Array:
    """A list column of numbers (N,) that lie end to end, row r from `start[r]` to `start[r + 1]`."""
    return pa.ListArray.from_arrays(start.astype(np.int32), pa.array(np.ascontiguousarray(values), kind), type=_list_of(kind))


def _list_of(kind: pa.DataType) -> pa.DataType:
    return pa.list_(pa.field("element", kind, nullable=False))  # no nulls: nothing to decode for each number


def write_shard_table(path: Path, columns: Mapping[str, pa.Array], kind: str, version: int) -> None:
    """Write the columns as one row group of a file that says what it is."""
    table = table_of(columns)
    with shard_writer(path, table.schema, kind, version) as write:
        write(table)


def table_of(columns: Mapping[str, pa.Array]) -> pa.Table:
    """Columns side by side, none of them with nulls."""
    fields = [pa.field(name, array.type, nullable=False) for name, array in columns.items()]
    return pa.Table.from_arrays(list(columns.values()), schema=pa.schema(fields))


@contextmanager
def shard_writer(path: Path, fields: pa.Schema, kind: str, version: int) -> Iterator[Callable[[pa.Table], None]]:
    """What writes tables of `fields`, a row group each, into a file that says what it is and appears whole."""
    schema = fields.with_metadata({_KIND: kind.encode(), _VERSION: str(version).encode()})
    floats = [f"{f.name}.list.element" for f in fields if pa.types.is_list(f.type) and pa.types.is_floating(f.type.value_type)]
    with whole(path) as temporary:
        with pq.ParquetWriter(
            temporary,
            schema,
            compression="zstd",
            compression_level=3,
            use_dictionary=False,
            use_byte_stream_split=floats,
            write_statistics=False,
        ) as writer:
            yield lambda table: writer.write_table(table.cast(schema), row_group_size=max(1, table.num_rows))
            writer.add_key_value_metadata({"drivegen.checksum": BLANK})  # in the footer alone: the schema is there twice
        seal_file(temporary)


def read_groups(path: Path, kind: str, version: int) -> Iterator[Callable[[str], pa.Array]]:
    """What reads a column of each row group, one after the other. Raises as `read_shard_table`, KeyError for no such column."""
    with _readable(path):
        with path.open("rb") as raw, mmap(raw.fileno(), 0, access=ACCESS_READ) as content:
            expect_seal(content, path, _AGAIN)
        with open_parquet(path, path, by_groups=True) as file:
            _expect_kind(file.schema_arrow.metadata or {}, path, kind, version)
            for group in range(file.num_row_groups):
                yield partial(_column_of, file, group)


def _column_of(file: pq.ParquetFile, group: int, name: str) -> pa.Array:
    return file.read_row_group(group, [name], use_threads=False)[name].combine_chunks()


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Raises UnusableInput, reason `truncated`, naming `path`, where the block cannot read it."""
    try:
        yield
    except (pa.ArrowException, OSError, ValueError) as error:  # the last where an empty file is mapped
        what = (str(error).splitlines() or ["unreadable"])[0]
        raise UnusableInput(f"{path} is no whole shard ({what}): {_AGAIN}", reason="truncated") from None


def read_shard_table(path: Path, kind: str, version: int, columns: list[str] | None = None) -> Shard:
    """Read a shard back, or some of its columns; raises UnusableInput as `read_sealed` does."""
    return Shard(read_sealed(path, kind, version, columns))


def read_sealed(path: Path, kind: str, version: int, columns: list[str] | None = None) -> pa.Table:
    """Read back what a `shard_writer` wrote, or some of its columns.

    Raises UnusableInput naming the file: reason `truncated` if it is cut short, empty or no Parquet, `foreign-file` if it
    is not of this kind, `old-version` if another version of DriveGen wrote it, `damaged` if it is not what was written.
    """
    with _readable(path):
        raw = path.read_bytes()
        if marked := has_seal(raw):
            expect_seal(raw, path, _AGAIN)  # before anything is parsed
        with open_parquet(pa.BufferReader(raw), path) as file:
            _expect_kind(file.schema_arrow.metadata or {}, path, kind, version)
            if not marked:
                expect_seal(raw, path, _AGAIN)
            return file.read(columns, use_threads=False)


def _expect_kind(metadata: Mapping[bytes, bytes], path: Path, kind: str, version: int) -> None:
    if metadata.get(_KIND) != kind.encode():
        raise UnusableInput(f"{path} holds no {kind} of DriveGen", reason="foreign-file")
    if metadata.get(_VERSION) != str(version).encode():
        other = metadata.get(_VERSION, b"none").decode(errors="replace")
        raise UnusableInput(
            f"{path} holds {kind} of version {other}, this DriveGen reads {version}: run the stage that made it again",
            reason="old-version",
        )


def _rows(column: pa.ChunkedArray) -> list[Any]:
    """Each row's value: a flat array or a list of words for list columns, else the value itself."""
    array = column.combine_chunks() if column.num_chunks != 1 else column.chunk(0)
    if not pa.types.is_list(array.type):
        return list(array.to_pylist())
    start = array.offsets.to_numpy().tolist()
    if pa.types.is_string(array.type.value_type):
        values: Any = array.values.to_pylist()
    else:
        values = array.values.to_numpy(zero_copy_only=False)
        values = values if values.flags.writeable else values.copy()  # torch and numba mind read-only arrays
    return [values[a:b] for a, b in pairwise(start)]


def built(shard: Shard, path: Path, build: Callable[[Shard, int], Row]) -> list[Row]:
    """What `build` makes of each row; where it cannot, the shard is not what its kind and version say.

    Raises UnusableInput, reason `bad-shard`, naming the file and the row.
    """
    rows = []
    for row in range(shard.count):
        try:
            with naming(f"{path}, row {row}"):
                rows.append(build(shard, row))
        except (LookupError, ValueError, TypeError, AttributeError) as error:
            raise UnusableInput(f"{path}, row {row}, is no sound row ({error}): {_AGAIN}", reason="bad-shard") from None
    return rows
