"""The vehicle asset table, and that of gaps, each one sealed Parquet file; columns are those of `placement.table.Table.to_arrow`
and `Gaps.to_arrow`."""

from pathlib import Path

import pyarrow as pa

from drivegen.store.lists import read_sealed, shard_writer

_KIND, _VERSION = "assets", 1


def write_assets(path: Path, table: pa.Table) -> None:
    """Write the columns; same rows, same bytes."""
    with shard_writer(path, table.schema, _KIND, _VERSION) as write:
        write(table)


def read_assets(path: Path) -> pa.Table:
    """The columns. Raises UnusableInput, naming the file, for what is not what was written; see `store.lists.read_sealed`."""
    return read_sealed(path, _KIND, _VERSION)
