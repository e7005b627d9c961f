"""Every Parquet and Feather file that enters goes through here: counted before it is read, page checksums compared.

Both formats pack: a few hundred bytes may hold a column of a thousand million zeros.
"""

from collections.abc import Sequence
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
    _expect_few(together([0, *map(_elements, groups)]), place)
    _expect_few(together([0, *(group.total_byte_size for group in groups)]) // 8, place)
    return file


def _elements(group: pq.RowGroupMetaData) -> int:
    """Those of lists are counted, too."""
    return sum(group.column(i).num_values for i in range(group.num_columns))


def read_feather(path: Path, columns: Sequence[str]) -> pa.Table:
    """The columns of these names, no others. Raises as `pyarrow.feather.read_table`, and UnusableInput as `open_parquet`.

    Lists are refused, reason `missing-columns`: how many elements they have is not known before all are in memory.
    """
    with pa.OSFile(str(path)) as source:
        unread = pa.ipc.open_file(source)
        wanted = [i for i, name in enumerate(unread.schema.names) if name in columns]
        expect_flat(unread.schema, columns, path)
        _expect_few(unread.count_rows() * len(wanted), path)
        options = pa.ipc.IpcReadOptions(included_fields=wanted, use_threads=False)
        return pa.ipc.open_file(source, options=options).read_all()


def expect_flat(schema: pa.Schema, columns: Sequence[str], place: object) -> None:
    """Raise UnusableInput, reason `missing-columns`, naming `place`, where one of these columns holds no numbers and no words."""
    if lists := [field for field in schema if field.name in columns and not _is_flat(field.type)]:
        said = f"{place}: column {lists[0].name} holds {lists[0].type}, neither numbers nor words"
        raise UnusableInput(said, reason="missing-columns")


def _is_flat(kind: pa.DataType) -> bool:
    word = kind.value_type if pa.types.is_dictionary(kind) else kind
    return bool(pa.types.is_primitive(kind) or pa.types.is_string(word) or pa.types.is_large_string(word))


def _expect_few(values: int, place: object) -> None:
    if values > MOST_VALUES:
        raise UnusableInput(f"{place} holds {values} values, more than {MOST_VALUES}", reason="too-large")
