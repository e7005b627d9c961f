"""A checksum inside the very file that it is of, whatever the format: who copies the file copies it along.

The file is written with `BLANK` somewhere in its metadata; `sealed` puts the SHA-256 of those bytes in the blank's place.
Every bit is guarded, the format's own headers too, before anything is parsed.
"""

import hashlib
import re
from mmap import mmap
from pathlib import Path

from drivegen.core.errors import UnusableInput

_MARK = "drivegen-sha256:"
BLANK = _MARK + "0" * 64

_SEAL = re.compile(_MARK.encode() + rb"([0-9a-f]{64})")


def sealed(blank: bytes) -> bytes:
    """The file's bytes with their checksum in place of the one `BLANK` that they hold."""
    assert blank.count(BLANK.encode()) == 1
    return blank.replace(BLANK.encode(), f"{_MARK}{hashlib.sha256(blank).hexdigest()}".encode())


def seal_file(path: Path) -> None:
    """Make `sealed` bytes of a file's, in place, without reading all of it into memory."""
    with path.open("r+b") as file, mmap(file.fileno(), 0) as content:
        at = content.find(BLANK.encode())
        assert at >= 0 > content.find(BLANK.encode(), at + 1)
        content[at : at + len(BLANK)] = f"{_MARK}{hashlib.sha256(content).hexdigest()}".encode()


def has_seal(raw: bytes) -> bool:
    """Whether these bytes hold a checksum, right or wrong."""
    return _SEAL.search(raw) is not None


def expect_seal(raw: bytes | mmap, place: object, remedy: str) -> None:
    """Raise UnusableInput, reason `damaged`, naming `place`, unless these are the bytes that `sealed` gave."""
    seals = [(seal.span(), seal[1].decode()) for seal in _SEAL.finditer(raw)]
    if len(seals) != 1:
        raise UnusableInput(f"{place} has no checksum: {remedy}", reason="damaged")
    (begin, end), written = seals[0]
    with memoryview(raw) as view:
        digest = hashlib.sha256(view[:begin])
        digest.update(BLANK.encode())
        digest.update(view[end:])
    if digest.hexdigest() != written:
        raise UnusableInput(f"{place} is not what was written, by its checksum: {remedy}", reason="damaged")
