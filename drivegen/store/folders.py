"""A folder of results is written whole or not at all, as `files` does for one file."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drivegen.core.errors import UnusableInput
from drivegen.store.files import naming, part_of, sweep


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """A temporary folder beside `path` that takes its place when the block ends well, and is removed when it does not.

    What runs that were killed have left of it is removed, too. Raises UnusableInput where `path` is there and is no empty
    folder: nothing that lies there is replaced or mixed with.
    """
    path = Path(os.path.realpath(path))  # as resolve(), which raises where links lead in a circle
    if path.exists() and not path.is_dir():
        raise UnusableInput(f"{path} is there and no folder: name another one", reason="not-empty")
    if path.is_dir() and any(path.iterdir()):
        raise UnusableInput(f"{path} is not empty: name a new folder, or remove it first", reason="not-empty")
    sweep(path)
    temporary = part_of(path)
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
