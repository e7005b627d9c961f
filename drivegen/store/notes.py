"""What a shard was made from, as a small JSON file: so that a stage keeps the shards that still stand and makes the rest.

A note names its items and the hashes of the settings (and of the code) that made it, of the input files' bytes and of
the shard. It is written after its shard: a shard without a note was never finished.
"""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import orjson

from drivegen.store.files import write_json


@dataclass(frozen=True)
class ShardNote:
    """One shard's provenance.

    Attributes:
        items: what it was asked to hold, in order.
        settings: hash of everything that decides how items become rows.
        inputs: hash of the files that the items were read from.
        shard: its SHA-256, as `digest` gives it; of no file where no item gave a row.
        outcome: what the stage wants to remember of the making, plain JSON.
    """

    items: tuple[str, ...]
    settings: str
    inputs: str
    shard: str
    outcome: dict[str, Any]


def read_note(path: Path) -> ShardNote | None:
    """The note, or None where there is none or it cannot be read: then its shard is made again."""
    try:
        tree = orjson.loads(path.read_bytes())
        return ShardNote(tuple(tree["items"]), tree["settings"], tree["inputs"], tree["shard"], tree["outcome"])
    except (OSError, orjson.JSONDecodeError, KeyError, TypeError):
        return None


def write_note(path: Path, note: ShardNote) -> None:
    """Write the note; its shard must be there already."""
    write_json(path, asdict(note))


def stands(note: ShardNote | None, settings: str, inputs: str, shard: Path) -> bool:
    """Whether the shard that the note speaks of is there as it was written and would be made the same again."""
    return note is not None and (note.settings, note.inputs, note.shard) == (settings, inputs, digest([shard]))


def arrange(items: Sequence[str], notes: dict[int, ShardNote], settings: str, size: int) -> dict[int, tuple[str, ...]]:
    """Shard numbers with their items: shards that stand are kept, all other items fill new ones of `size`.

    A shard is kept if it was made with the same settings and all its items are still wanted; new shards take the lowest
    free numbers, so what is made from nothing does not depend on what was there before.
    """
    wanted = set(items)
    standing = {
        number: note.items for number, note in notes.items() if note.settings == settings and wanted.issuperset(note.items)
    }
    held = {item for shard in standing.values() for item in shard}
    rest = [item for item in items if item not in held]
    parts = [tuple(rest[i : i + size]) for i in range(0, len(rest), size)]
    free = (number for number in range(len(standing) + len(parts)) if number not in standing)
    return standing | dict(zip(free, parts, strict=False))


def digest(paths: Iterable[Path]) -> str:
    """A hash of the files' names and bytes, whatever their order and however often one is named."""
    total = hashlib.sha256()
    for path in sorted(set(paths)):
        stat = path.stat() if path.is_file() else None
        total.update(path.name.encode() + (_digest_of(path, stat.st_size, stat.st_mtime_ns) if stat else b"absent"))
    return total.hexdigest()


@lru_cache(maxsize=4096)
def _digest_of(path: Path, size: int, changed: int) -> bytes:  # noqa: ARG001 - size and time are part of the cache's key
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()
