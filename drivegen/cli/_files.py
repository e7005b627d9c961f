"""The file that a command writes: what cannot be written, or would cost another file, is refused before any work."""

import errno
import os
import re
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile

from drivegen.core.errors import UnusableInput
from drivegen.store.files import expect_file_fits

_HEAD = 65_536
"""Bytes in which a file says what it is: before its root element XML may have comments."""

_FULL = (errno.ENOSPC, errno.EDQUOT)
_XML = rb"\s*(<\?xml.*?\?>\s*)?(<!--.*?-->\s*)*"


@dataclass(frozen=True)
class Kind:
    """A kind of file in words, and how its bytes begin."""

    name: str
    begins: bytes

    def holds(self, path: Path) -> bool:
        """Whether the file at `path` begins so."""
        with path.open("rb") as file:
            return re.match(self.begins, file.read(_HEAD), re.DOTALL) is not None


RECORDING = Kind("recording of Rerun", rb"RRF\d")
BUNDLE = Kind("file of `drivegen weights save`", rb"PK\x03\x04.{26}manifest\.json")
RATE = Kind("file of `drivegen rate`", rb'{\s*"draws"')
SPEED = Kind("file of `drivegen bench`", rb'\[\s*{\s*"name"')
MAPS = Kind("file of `drivegen bench maps`", rb'{\s*"descriptions"')
NETWORK = Kind("SUMO network", _XML + rb"<net[\s>]")
OPENDRIVE = Kind("OpenDRIVE map", _XML + rb"<OpenDRIVE[\s>]")


def expect_own(path: Path, kind: Kind) -> None:
    """Raises UnusableInput where `path` cannot be written, or holds something that is not of this kind and would be lost."""
    expect_file_fits(path)
    expect_writable(path)
    if path.is_file() and path.stat().st_size and not kind.holds(path):
        raise UnusableInput(f"{path} is there and no {kind.name}: name another file, or move that one away first")


def lies_in(path: Path, folder: Path) -> bool:
    """Whether `path` leads below `folder`; links may lead in a circle, which Path.resolve does not take."""
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def expect_writable(path: Path) -> None:
    """Raises UnusableInput where the folder of `path`, or the nearest above it that is there, takes no files.

    It is tried, for rights alone do not say; a full disk remains an OSError.
    """
    there = next(folder for folder in path.absolute().parents if folder.is_dir())
    try:
        TemporaryFile(dir=there).close()
    except OSError as error:
        if error.errno in _FULL:
            raise
        raise UnusableInput(f"{path} cannot be written, {there} takes no files: name a place that does") from None
