"""Files are written whole or not at all, with the same bytes for the same content."""

import os
import re
import shutil
import socket
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import orjson
import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.core.errors import UnusableInput

HOST = socket.gethostname()


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well, and is removed when it does not.

    What runs that were killed have left of it is removed, too. Raises UnusableInput as `expect_file_fits`. An OSError, as from a
    full disk, names `path`.
    """
    expect_file_fits(path)
    temporary = part_of(path)
    with naming(path, temporary):
        path.parent.mkdir(parents=True, exist_ok=True)
        sweep(path)
        try:
            yield temporary
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)


def content_of(path: Path) -> bytes:
    """The file's bytes. Raises UnusableInput, reason `truncated`, where it is no file or cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise UnusableInput(f"{path} cannot be read ({error.strerror}): copy it again", reason="truncated") from None


def expect_file_fits(path: Path) -> None:
    """Raises UnusableInput where something else than a plain file is at `path`, a link included, or it would lie in a file."""
    if path.is_symlink() or (path.exists() and not path.is_file()):  # never replace a device, or what leads to it
        raise UnusableInput(f"{path} is there and no plain file: name another one", reason="not-a-file")
    if wrong := [parent for parent in path.parents if parent.exists() and not parent.is_dir()]:
        raise UnusableInput(f"{wrong[0]} is there and no folder: name another one", reason="not-a-folder")


def part_of(path: Path) -> Path:
    """Where this process writes before `path` is replaced; machines that share a folder have processes of the same number."""
    return path.with_name(f".{path.name}.{HOST}.{os.getpid()}.part")


def sweep(path: Path) -> None:
    """Remove temporary files and folders for `path` whose process, one of this machine, was killed before it did so."""
    ours = re.compile(rf"\.{re.escape(f'{path.name}.{HOST}')}\.(\d{{1,9}})\.part(\.wal)?")  # DuckDB writes one beside
    for leftover in path.parent.glob(".*.part*"):
        if (name_parts := ours.fullmatch(leftover.name)) and not _runs(int(name_parts[1])):
            with suppress(OSError):
                leftover.unlink() if leftover.is_file() else shutil.rmtree(leftover)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # somebody else's
        return True
    return True


@contextmanager
def naming(path: Path, temporary: Path) -> Iterator[None]:
    """An OSError of the block names the file or folder that was asked for, not the temporary one, and never nothing."""
    try:
        yield
    except OSError as error:
        error.filename = str(error.filename or path).replace(str(temporary), str(path))
        raise


def write_together(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Files of one folder that belong together: none is replaced before all are written, and a new folder goes with them."""
    new = not folder.exists()
    try:
        with ExitStack() as stack:
            for name, content in contents.items():
                stack.enter_context(whole(folder / name)).write_bytes(content)
    except BaseException:
        if new:
            with suppress(OSError):
                folder.rmdir()
        raise


def as_json(value: Any) -> bytes:
    """Sorted, indented JSON; NumPy scalars and arrays are welcome, NaN becomes null, `?` what is no UTF-8 in a file's name."""
    options = orjson.OPT_SORT_KEYS | orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_APPEND_NEWLINE
    try:
        return orjson.dumps(value, option=options)
    except orjson.JSONEncodeError:
        return orjson.dumps(_in_utf8(value), option=options)


def _in_utf8(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {_in_utf8(name): _in_utf8(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_in_utf8(one) for one in value]
    return value.encode("utf-8", "replace").decode() if isinstance(value, str) else value


def write_bytes(path: Path, raw: bytes) -> None:
    """A file of these bytes, written whole."""
    with whole(path) as temporary:
        temporary.write_bytes(raw)


def write_json(path: Path, value: Any) -> None:
    """A file of `as_json`."""
    write_bytes(path, as_json(value))


def write_table(path: Path, table: pa.Table) -> None:
    """Parquet with zstd; nothing in it depends on when or where it was written."""
    with whole(path) as temporary, temporary.open("wb") as file:
        pq.write_table(table, file, compression="zstd", compression_level=3)
