"""Every Parquet and Feather file that enters goes through here: counted before it is read, page checksums compared.

Both formats pack: a few hundred bytes may hold a column of a thousand million zeros.
"""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.ipc
import pyarrow.parquet as pq

from drivegen.core.errors import UnusableInput

MOST_VALUES = 250_000_000
"""Of all columns together: 2 GB in memory. The largest recordings and shards of ours hold a twentieth of it."""


def open_parquet(source: Any, place: object, by_groups: bool = False, **options: Any) -> pq.ParquetFile:
    """The open file; `source` and `options` as of `pq.ParquetFile`, whose errors are raised where it is none.

    Raises UnusableInput, reason `too-large`, naming `place`, where it, or `by_groups` one of its row groups, holds more than
    `MOST_VALUES`.
    """
    file = pq.ParquetFile(source, page_checksum_verification=True, **options)
    about = file.metadata
    groups = [about.row_group(i) for i in range(about.num_row_groups)]
    together = max if by_groups else sum
    _expect_few(together([0, *(group.num_rows * about.num_columns for group in groups)]), place)
    _expect_few(together([0, *(group.total_byte_size for group in groups)]) // 8, place)
    return file


def read_feather(path: Path) -> pa.Table:
    """The whole table. Raises as `pyarrow.feather.read_table`, and UnusableInput as `open_parquet`."""
    with pa.OSFile(str(path)) as source:
        blank = pa.ipc.open_file(source, options=pa.ipc.IpcReadOptions(included_fields=[]))
        rows = sum(blank.get_batch(i).num_rows for i in range(blank.num_record_batches))
        _expect_few(rows * len(blank.schema), path)
        return pa.ipc.open_file(source, options=pa.ipc.IpcReadOptions(use_threads=False)).read_all()


def _expect_few(values: int, place: object) -> None:
    if values > MOST_VALUES:
        raise UnusableInput(f"{place} holds {values} values, more than {MOST_VALUES}", reason="too-large")
