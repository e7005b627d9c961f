"""A checksum inside the very file that it is of, whatever the format: who copies the file copies it along.

The file is written with `BLANK` somewhere in its metadata; `sealed` puts the SHA-256 of those bytes in the blank's place.
Every bit is guarded, the format's own headers too, before anything is parsed.
"""

import hashlib
import re

from drivegen.core.errors import UnusableInput

_MARK = "drivegen-sha256:"
BLANK = _MARK + "0" * 64

_SEAL = re.compile(_MARK.encode() + rb"([0-9a-f]{64})")


def sealed(blank: bytes) -> bytes:
    """The file's bytes with their checksum in place of the one `BLANK` that they hold."""
    assert blank.count(BLANK.encode()) == 1
    return blank.replace(BLANK.encode(), f"{_MARK}{hashlib.sha256(blank).hexdigest()}".encode())


def has_seal(raw: bytes) -> bool:
    """Whether these bytes hold a checksum, right or wrong."""
    return _SEAL.search(raw) is not None


def expect_seal(raw: bytes, place: object, remedy: str) -> None:
    """Raise UnusableInput, reason `damaged`, naming `place`, unless these are the bytes that `sealed` gave."""
    seals = _SEAL.findall(raw)
    if len(seals) != 1:
        raise UnusableInput(f"{place} has no checksum: {remedy}", reason="damaged")
    if hashlib.sha256(_SEAL.sub(BLANK.encode(), raw)).hexdigest() != seals[0].decode():
        raise UnusableInput(f"{place} is not what was written, by its checksum: {remedy}", reason="damaged")
