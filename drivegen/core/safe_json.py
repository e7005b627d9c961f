"""Every JSON file that others may have written is parsed here: its bytes and its values are counted first.

A value takes two bytes in a file and a hundred in memory. Depth is orjson's to refuse (1 024).
"""

from typing import Any

import orjson

from drivegen.core.errors import UnusableInput

MAX_BYTES = 200 * 1024 * 1024
"""Hundreds of times the largest map archive of Argoverse 2."""

MAX_VALUES = 10_000_000
"""So many take 1 GB in memory. A map archive of `MAX_BYTES` holds as many: 20 bytes a value."""


def parse(raw: bytes, place: object, reason: str = "not-json") -> Any:
    """The value in `raw`. Raises UnusableInput, naming `place`: for what is no JSON with this reason, else `too-large`."""
    many = len(raw) > MAX_VALUES and sum(map(raw.count, (b",", b"[", b"{", b":"))) > MAX_VALUES  # those in strings count, too
    if len(raw) > MAX_BYTES or many:
        raise UnusableInput(f"{place} has more than {MAX_BYTES >> 20} MB or {MAX_VALUES} values", reason="too-large")
    try:
        return orjson.loads(raw)
    except orjson.JSONDecodeError as error:
        raise UnusableInput(f"{place} is not JSON: {error}", reason=reason) from None
