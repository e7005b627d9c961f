"""Stage ingest: recordings to shards of scenarios, each accepted or rejected with a counted reason.

argv: the embedded corpus, the folder of scenarios (gets {train,val,test}/shard-*.parquet, rejected.parquet,
counts.parquet and notes/), the counts (JSON). The folder is kept between runs: shards that would be made the same again
are left alone, so more recordings mean more shards and a kill costs one.
"""

import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

import orjson

import drivegen
from drivegen import plugins
from drivegen.datasets._admission import Admission, accounts
from drivegen.datasets._splits import CORPUS, SPLITS, Plan, items, trained_on
from drivegen.datasets.base import Dataset
from drivegen.errors import UnusableInput
from drivegen.selection import Settings
from drivegen.settings import Count, Index
from drivegen.store.files import whole, write_json, write_table
from drivegen.store.notes import ShardNote, arrange, digest, read_note, stands, write_note
from drivegen.store.scenarios import shards, write_shard
from stages._door import enter, spread

CODE = ("*.py", "av2/*.py", "commonroad/*.py", "datasets/*.py", "store/lists.py", "store/scenarios.py")
"""What decides how a recording becomes a row; when it changes, all shards are made again."""

EMPTY = "no-scenes.txt"
"""What a split without shards holds."""


@dataclass(frozen=True)
class Params:
    """Section `ingest`.

    Attributes:
        source: the data set that is regenerated and measured on. root: its folder; the corpus has its own.
        train_on: the data sets that models are trained on. roots: folders of those that are neither source nor corpus.
        held_out, limits: see `datasets._splits.Plan`.
        fewest_tracks: with fewer usable training tracks a data set is not trained on, but the corpus.
        shard_size: scenarios to a file.
        selection: see `selection.Settings`. horizons: the horizon of data sets whose recordings are short [steps], in place
            of the selection's: errors over horizons of different length are not averaged together.
    """

    workers: Count
    source: str
    root: str
    train_on: tuple[str, ...]
    roots: dict[str, str]
    held_out: dict[str, str]
    fewest_tracks: Index
    limits: dict[str, int | None]
    shard_size: Count
    selection: Settings
    horizons: dict[str, int]

    def selected(self, source: str) -> Settings:
        """How recordings of this data set become scenarios."""
        return replace(self.selection, horizon=self.horizons.get(source, self.selection.horizon))


@dataclass(frozen=True)
class Task:
    """One shard: items `<data set>/<its split>/<scene>`, and the folder and the selection of each data set."""

    items: tuple[str, ...]
    roots: dict[str, Path]
    shard: Path
    note: Path
    settings: str
    selections: dict[str, Settings]


def main(params: Params, corpus: Path, out: Path, metrics: Path) -> dict[str, float]:
    """Plan the shards, make those that do not stand yet, count everything."""
    plugins.load("datasets", params.source)  # a misspelt one is the first thing to say
    own = {} if params.source == CORPUS else {params.source: Path(params.root)}
    roots = {**{name: Path(root) for name, root in params.roots.items()}, **own, CORPUS: corpus}
    if unknown := [name for name in params.train_on if name not in roots]:
        raise UnusableInput(f"ingest.train_on names {unknown[0]!r}, but ingest.roots has no folder for it")

    def opened(name: str) -> Dataset:
        return _open(name, roots[name])

    names, note = trained_on(params.train_on, opened, params.selected, params.fewest_tracks)
    plan = Plan(params.source, names, params.held_out, params.limits)
    settings = _settings_hash(params)
    tasks = {split: list(_tasks(params, roots, items(plan, opened, split), out, split, settings)) for split in SPLITS}
    total = {split: Admission() for split in SPLITS}
    of_task = {task.note: total[split] for split in SPLITS for task in tasks[split]}
    for task, admission in spread(make_shard, [t for split in SPLITS for t in tasks[split]], params.workers, "ingest"):
        of_task[task.note].add(admission)
    for name, table in accounts(total).items():
        write_table(out / f"{name}.parquet", table)
    _check(total, out / "rejected.parquet")
    for split in SPLITS:
        _tell_if_empty(out / split, params.source)
    described = ", ".join(opened(name).description for name in names)
    write_json(metrics, {"trained_on": described, "note": note, "splits": {s: found.counts for s, found in total.items()}})
    return {"scenarios": float(sum(found.accepted for found in total.values()))}


@lru_cache
def _open(name: str, root: Path) -> Dataset:
    opened: Dataset = plugins.load("datasets", name)(root)
    return opened


def _settings_hash(params: Params) -> str:
    """Hash of what decides, besides the files, how items become rows: settings and code."""
    total = hashlib.sha256(orjson.dumps([asdict(params.selection), params.horizons], option=orjson.OPT_SORT_KEYS))
    package = Path(drivegen.__file__).parent
    for path in sorted([Path(__file__), *(path for pattern in CODE for path in package.glob(pattern))]):
        total.update(path.read_bytes())
    return total.hexdigest()


def _tasks(params: Params, roots: dict[str, Path], wanted: list[str], out: Path, split: str, settings: str) -> Iterator[Task]:
    """All shards of a split; files of shards that are not wanted any more are removed."""
    folder, notes = out / split, out / "notes" / split
    for leftover in (*out.glob(".*.part"), *folder.glob(".*.part"), *notes.glob(".*.part")):
        leftover.unlink()  # of a run that was killed
    known = {_number(path): note for path in notes.glob("shard-*.json") if (note := read_note(path))}
    selections = {name: params.selected(name) for name in roots}
    arranged = arrange(wanted, known, settings, params.shard_size)
    for path in (*folder.glob("shard-*.parquet"), *notes.glob("shard-*.json")):
        if _number(path) not in arranged:
            path.unlink()
    for number, held in sorted(arranged.items()):
        name = f"shard-{number:05d}"
        yield Task(held, roots, folder / f"{name}.parquet", notes / f"{name}.json", settings, selections)


def _number(shard: Path) -> int:
    return int(shard.stem.partition("-")[2])


def make_shard(task: Task) -> Admission:
    """What became of one shard's items; the shard is made now unless it stands already."""
    note = read_note(task.note)
    inputs = digest(path for item in task.items for path in _files(task, item))
    if note is None or not stands(note, task.settings, inputs, task.shard):
        for old in (task.note, task.shard):
            old.unlink(missing_ok=True)
        admission = Admission()
        found = [admission.admit(*_scene(task, item), task.selections[item.partition("/")[0]]) for item in task.items]
        if scenarios := [scenario for scenario in found if scenario is not None]:
            write_shard(task.shard, scenarios)
        size = task.shard.stat().st_size if scenarios else 0
        note = ShardNote(task.items, task.settings, inputs, size, admission.as_tree())
        write_note(task.note, note)
    return Admission.of_tree(note.outcome)


def _scene(task: Task, item: str) -> tuple[Dataset, str, str]:
    name, split, scene = item.split("/", 2)
    return _open(name, task.roots[name]), split, scene


def _files(task: Task, item: str) -> tuple[Path, ...]:
    data, split, scene = _scene(task, item)
    try:
        return data.files(split, scene)
    except UnusableInput:
        return ()  # reading will say what is missing


def _check(total: dict[str, Admission], rejected: Path) -> None:
    for split in ("train", "test"):
        if not total[split].accepted:
            said = _reasons(total[split].rejected) or "there are none"
            remedy = f"see {rejected}, ingest.root and ingest.held_out"
            raise UnusableInput(f"no scene can be used as {split} scenario ({said}); {remedy}")
    if rows := [row for found in total.values() for row in found.rejected]:
        print(f"ingest: {len(rows)} scenes rejected ({_reasons(rows)}): {rejected} says why of each")


def _reasons(rejected: list[tuple[str, ...]]) -> str:
    return ", ".join(f"{count} x {reason}" for reason, count in Counter(row[2] for row in rejected).most_common(5))


def _tell_if_empty(folder: Path, source: str) -> None:
    """Leave a sentence in a split without shards: stages depend on its folder, and DVC's cache keeps no empty folder."""
    said = folder / EMPTY
    if shards(folder):
        said.unlink(missing_ok=True)
    else:
        sentence = f"No scene is in this split (source: {source}): what is measured on it is missing from the tables.\n"
        with whole(said) as temporary:
            temporary.write_text(sentence)


if __name__ == "__main__":
    enter("ingest", Params, main)
