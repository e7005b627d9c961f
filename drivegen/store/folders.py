"""A folder of results is written whole or not at all, as `files` does for one file."""

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drivegen.errors import UnusableInput
from drivegen.store.files import naming


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """A temporary folder beside `path` that takes its place when the block ends well, and is removed when it does not.

    What runs that were killed have left of it is removed, too. Raises UnusableInput where `path` is there and is no empty
    folder: nothing that lies there is replaced or mixed with.
    """
    path = path.resolve()
    if path.exists() and not path.is_dir():
        raise UnusableInput(f"{path} is there and no folder: name another one", reason="not-empty")
    if path.is_dir() and any(path.iterdir()):
        raise UnusableInput(f"{path} is not empty: name a new folder, or remove it first", reason="not-empty")
    _sweep(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    with naming(path, temporary):
        try:
            temporary.mkdir(parents=True)
        except (FileExistsError, NotADirectoryError):
            raise UnusableInput(f"{path} would lie in a file: name another folder", reason="not-a-folder") from None
        try:
            yield temporary
            temporary.replace(path)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)


def _sweep(path: Path) -> None:
    """Remove temporary folders for `path` whose process has ended without doing so, as one that was killed has."""
    ours = re.compile(rf"\.{re.escape(path.name)}\.(\d+)\.part")
    for leftover in path.parent.glob(".*.part"):
        if (found := ours.fullmatch(leftover.name)) and not _runs(int(found[1])):
            shutil.rmtree(leftover, ignore_errors=True)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # somebody else's
        return True
    return True
