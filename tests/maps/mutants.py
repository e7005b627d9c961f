"""Seeded mutators of words, specifications, XML and replies, and the watch under which mutants are tried."""

import copy
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

COUNT = int(os.environ.get("DRIVEGEN_FUZZ", "40"))
"""Mutants of each sort, or a small multiple; `make fuzz` sets it."""

LONGEST = 20
"""No mutant may take longer [s]."""

NASTY = [0, -1, 1e9, float("nan"), float("inf"), "", "x" * 5000, None, [], {}, True, "../../etc/passwd", "&x;", "\u202e", 8, 45.0]
WORDS = ["not", "no", "without", "2", "nine hundred", "lanes", "by", "0", "-3", "1e9", "km/h", "roundabout", "crossing", "ramp"]
WORDS += [",", ".", "(", "then", "and", "of the", "to", "one-way", "交叉口", "Kreuzung"]
BYTES = [b"<", b">", b'"', b"", b"nan", b"-1", b"1e400", b"<!DOCTYPE x>", b"\x00", b"</net>", b"from", b"lane", b" " * 50]
BYTES += [b"100000", b"&e;", b'<!DOCTYPE n [<!ENTITY e SYSTEM "file:///etc/passwd">]>', b"9" * 400, b"../../x", b"'/>", b"\xff"]


def mutated_text(rng: np.random.Generator, text: str) -> str:
    words = text.split() or [""]
    for _ in range(rng.integers(1, 5)):
        place = int(rng.integers(len(words) + 1))
        if rng.random() < 0.5:
            words.insert(place, str(rng.choice(WORDS)))
        elif len(words) > 1:
            words.pop(min(place, len(words) - 1))
    return " ".join(words)


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [p for key, item in items for p in [(*path, key), *places(item, (*path, key))]]


def mutated_spec(rng: np.random.Generator, fields: dict[str, Any]) -> dict[str, Any]:
    fields = copy.deepcopy(fields)
    for _ in range(rng.integers(1, 3)):
        *way, last = (found := places(fields))[int(rng.integers(len(found)))]
        parent = fields
        for key in way:
            parent = parent[key]
        number = isinstance(parent[last], int | float) and rng.random() < 0.7
        scale = float(rng.choice([0.5, 0.9, 1.1, 2.0, -1.0]))
        parent[last] = type(parent[last])(parent[last] * scale) if number else NASTY[int(rng.integers(len(NASTY)))]
    return fields


def mutated_bytes(rng: np.random.Generator, raw: bytes) -> bytes:
    for _ in range(rng.integers(1, 4)):
        a = int(rng.integers(len(raw)))
        b = a + int(rng.choice([0, 1, 3, 40]))
        raw = raw[:a] + BYTES[int(rng.integers(len(BYTES)))] + raw[b:]
    return raw


def mutated_numbers(rng: np.random.Generator, text: str) -> str:
    """XML that stays XML: a few attributes' values are exchanged for one another's or for something nasty."""
    parts = text.split('"')
    values = list(range(1, len(parts), 2))
    for _ in range(rng.integers(1, 4)):
        place = int(rng.choice(values))
        other = parts[int(rng.choice(values))]
        nasty = str(rng.choice(["0", "-1", "1e9", "nan", "100000", "0.001", "8", "44", "5000", "../x", ""]))
        parts[place] = other if rng.random() < 0.5 else nasty
    return '"'.join(parts)


@contextmanager
def at_most(seconds: int = LONGEST) -> Iterator[None]:
    """Fails where its block takes longer, also where the block never ends."""

    def late(*_: object) -> None:
        raise AssertionError(f"a mutant took longer than {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


class Watch:
    """Notes every file that this process opens while it is on: to write outside `folder`, or to read where nobody should."""

    def __init__(self) -> None:
        self.folder: Path | None = None
        self.strayed: list[str] = []
        sys.addaudithook(self._see)  # a hook can't be taken away again, so it sleeps

    @contextmanager
    def over(self, folder: Path) -> Iterator[list[str]]:
        self.folder, self.strayed = folder, []
        try:
            yield self.strayed
        finally:
            self.folder = None

    def _see(self, event: str, arguments: tuple[Any, ...]) -> None:
        if self.folder is None or event != "open" or not isinstance(arguments[0], str | bytes):
            return
        path, flags = str(Path(os.fsdecode(arguments[0])).absolute()), arguments[2] or 0
        writes = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        if not path.startswith((str(self.folder), "/dev/null")) and (writes or path.startswith(("/etc/passwd", "/root/."))):
            self.strayed.append(path)


WATCH = Watch()
