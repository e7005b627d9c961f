"""The vehicle asset table as one Parquet file; its columns are those of `placement.table.Table.to_arrow`."""

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.core.errors import UnusableInput
from drivegen.store.files import write_table


def write_assets(path: Path, table: pa.Table) -> None:
    """Write the columns; same rows, same bytes."""
    write_table(path, table)


def read_assets(path: Path) -> pa.Table:
    """The columns. Raises UnusableInput, naming the file, where it is cut short or no Parquet."""
    try:
        return pq.read_table(path, use_threads=False)
    except (pa.ArrowException, OSError) as error:
        raise UnusableInput(f"{path} cannot be read as a table of assets: {error}", reason="truncated") from None
