"""Files are written whole or not at all, with the same bytes for the same content."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import orjson
import pyarrow as pa
import pyarrow.parquet as pq


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well, and is removed when it does not."""
    if path.exists() and not path.is_file():
        raise FileExistsError(errno.EEXIST, "is there and no plain file", str(path))  # never replace a device
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_json(path: Path, value: Any) -> None:
    """Sorted, indented JSON; NumPy scalars and arrays are welcome, NaN becomes null."""
    options = orjson.OPT_SORT_KEYS | orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_APPEND_NEWLINE
    with whole(path) as temporary:
        temporary.write_bytes(orjson.dumps(value, option=options))


def write_table(path: Path, table: pa.Table) -> None:
    """Parquet with zstd; nothing in it depends on when or where it was written."""
    with whole(path) as temporary:
        pq.write_table(table, temporary, compression="zstd", compression_level=3)
