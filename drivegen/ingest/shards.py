"""The shards of a split: which are kept, which are made, and what became of the recordings in each.

A shard that would be made the same again is left alone, so more recordings mean more shards, and a killed run loses one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from drivegen.ingest.admission import Admission
from drivegen.ingest.sources import Sources
from drivegen.store.files import whole
from drivegen.store.notes import ShardNote, arrange, digest, read_note, stands, write_note
from drivegen.store.scenarios import shards, write_shard

EMPTY = "no-scenes.txt"
"""What a split without shards holds."""


@dataclass(frozen=True)
class Task:
    """One shard.

    Attributes:
        items: `<data set>/<its split>/<scene>` of each recording, in order. sources: what they are read from.
        shard, note: the files to write. settings: hash of what decides, besides the files, how items become rows.
    """

    items: tuple[str, ...]
    sources: Sources
    shard: Path
    note: Path
    settings: str


def plan_shards(items: Sequence[str], sources: Sources, settings: str, size: int, out: Path, split: str) -> Iterator[Task]:
    """All shards of a split below `out`, of `size` items each; files of shards that are not among them are removed.

    `settings` is the hash that `Task` has.
    """
    folder, notes = out / split, out / "notes" / split
    for leftover in (*out.glob(".*.part"), *folder.glob(".*.part"), *notes.glob(".*.part")):
        leftover.unlink()  # of a run that was killed
    by_number = {_number(path): note for path in notes.glob("shard-*.json") if (note := read_note(path))}
    arranged = arrange(items, by_number, settings, size)
    for path in (*folder.glob("shard-*.parquet"), *notes.glob("shard-*.json")):
        if _number(path) not in arranged:
            path.unlink()
    for number, held in sorted(arranged.items()):
        name = f"shard-{number:05d}"
        yield Task(held, sources, folder / f"{name}.parquet", notes / f"{name}.json", settings)


def make_shard(task: Task) -> Admission:
    """What became of one shard's items; the shard is written unless it would be the same again."""
    note = read_note(task.note)
    inputs = digest(path for item in task.items for path in task.sources.files(item))
    if note is None or not stands(note, task.settings, inputs, task.shard):
        for old in (task.note, task.shard):
            old.unlink(missing_ok=True)
        note = _write(task, inputs)
    return Admission.of_tree(note.outcome)


def _write(task: Task, inputs: str) -> ShardNote:
    admission, sources = Admission(), task.sources
    admitted = [admission.admit(*sources.scene(item), sources.settings(item.partition("/")[0])) for item in task.items]
    if scenarios := [scenario for scenario in admitted if scenario is not None]:
        write_shard(task.shard, scenarios)
    note = ShardNote(task.items, task.settings, inputs, digest([task.shard]), admission.as_tree())
    write_note(task.note, note)
    return note


def note_if_empty(folder: Path, source: str) -> None:
    """Leave a sentence in a split without shards: stages depend on its folder, and DVC's cache keeps no empty folder."""
    note = folder / EMPTY
    if shards(folder):
        note.unlink(missing_ok=True)
    else:
        sentence = f"No scene is in this split (source: {source}): what is measured on it is missing from the tables.\n"
        with whole(note) as temporary:
            temporary.write_text(sentence)


def _number(shard: Path) -> int:
    return int(shard.stem.partition("-")[2])
