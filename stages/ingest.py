"""Stage ingest: recordings to shards of scenarios, each accepted or rejected with a counted reason.

argv: the embedded corpus, the folder of scenarios (gets {train,val,test}/shard-*.parquet, rejected.parquet,
counts.parquet and notes/), the counts (JSON). The folder is kept between runs: shards that would be made the same again
are left alone, so more recordings mean more shards and a kill costs one.
"""

import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pyarrow as pa

import drivegen
from drivegen import plugins
from drivegen.datasets.base import Dataset
from drivegen.errors import UnusableInput
from drivegen.recorded import RecordedLog
from drivegen.scenario import Scenario, SizeSource
from drivegen.seeds import derive
from drivegen.selection import Settings, select
from drivegen.store.files import write_json, write_table
from drivegen.store.notes import ShardNote, arrange, digest, read_note, stands, write_note
from drivegen.store.scenarios import write_shard
from stages._door import enter, spread

CORPUS = "sumo_corpus"
SPLITS = ("train", "val", "test")

VAL_SHARE = 20
"""One in so many training scenes is held back for validation where a source's own val split is our test split."""

CODE = ("*.py", "av2/*.py", "datasets/*.py", "store/lists.py", "store/scenarios.py")
"""What decides how a recording becomes a row; when it changes, all shards are made again."""


@dataclass(frozen=True)
class Params:
    """Section `ingest`.

    Attributes:
        source: the data set that is regenerated and measured on. root: its folder; the corpus has its own.
        train_on: the data sets that models are trained on. roots: folders of those that are neither source nor corpus.
        held_out: the split of each data set that is measured on; where a source is not trained on, all its splits are.
        fewest_tracks: with fewer usable training tracks a source is not trained on, but the corpus.
        limits: at most so many scenes per split of ours; null for all.
        shard_size: scenarios to a file.
        selection: see `selection.Settings`.
    """

    workers: int
    source: str
    root: str
    train_on: tuple[str, ...]
    roots: dict[str, str]
    held_out: dict[str, str]
    fewest_tracks: int
    limits: dict[str, int | None]
    shard_size: int
    selection: Settings


@dataclass(frozen=True)
class Task:
    """One shard: items `<data set>/<its split>/<scene>`, and the folder of each data set."""

    items: tuple[str, ...]
    roots: dict[str, Path]
    shard: Path
    note: Path
    settings: str
    selection: Settings


@dataclass
class Outcome:
    """What became of items: numbers by data set, and (data set, scene, reason, sentence) of each rejected one."""

    counts: dict[str, Counter[str]]
    rejected: list[tuple[str, ...]]


def main(params: Params, corpus: Path, out: Path, metrics: Path) -> dict[str, float]:
    """Plan the shards, make those that do not stand yet, count everything."""
    own = {} if params.source == CORPUS else {params.source: Path(params.root)}
    roots = {**{name: Path(root) for name, root in params.roots.items()}, **own, CORPUS: corpus}
    trained_on, note = _trained_on(params, roots)
    tasks = {split: list(_tasks(params, roots, trained_on, split, out)) for split in SPLITS}
    flat = [task for split in SPLITS for task in tasks[split]]
    outcomes = dict(
        zip((task.note for task in flat), (o for _, o in spread(make_shard, flat, params.workers, "ingest")), strict=True)
    )
    found = {split: _summed([outcomes[task.note] for task in tasks[split]]) for split in SPLITS}
    _check(found)
    _write_tables(out, found)
    described = ", ".join(_open(name, roots[name]).description for name in trained_on)
    write_json(metrics, {"trained_on": described, "note": note, "splits": {s: o.counts for s, o in found.items()}})
    return {"scenarios": float(sum(counts["accepted"] for o in found.values() for counts in o.counts.values()))}


@lru_cache
def _open(source: str, root: Path) -> Dataset:
    opened: Dataset = plugins.load("datasets", source)(root)
    return opened


def _trained_on(params: Params, roots: dict[str, Path]) -> tuple[tuple[str, ...], str]:
    """The data sets that models are trained on, and a sentence where that is not what was asked for."""
    if unknown := [name for name in params.train_on if name not in roots]:
        raise UnusableInput(f"ingest.train_on names {unknown[0]!r}, but ingest.roots has no folder for it")
    names, notes = [], []
    for name in params.train_on:
        if name != CORPUS and (found := _usable_tracks(params, name, roots[name])) < params.fewest_tracks:
            notes.append(f"{name} has {found} usable training tracks, fewer than {params.fewest_tracks}: not trained on")
        else:
            names.append(name)
    return tuple(names or [CORPUS]), "; ".join(notes)


def _usable_tracks(params: Params, source: str, root: Path) -> int:
    """Vehicle tracks seen for half of a scenario or longer in the training split; counting stops when there are enough."""
    data, found = _open(source, root), 0
    for scene in data.scenes("train"):
        try:
            scenario = select(data.read("train", scene), params.selection)
        except UnusableInput:
            continue
        found += _seen_long(scenario)
        if found >= params.fewest_tracks:
            break
    return found


def _seen_long(scenario: Scenario) -> int:
    return 0 if scenario.log is None else int(np.count_nonzero(scenario.log.valid.mean(-1) >= 0.5))


def _tasks(params: Params, roots: dict[str, Path], trained_on: tuple[str, ...], split: str, out: Path) -> Iterator[Task]:
    """All shards of a split; files of shards that are not wanted any more are removed."""
    folder, notes, settings = out / split, out / "notes" / split, _settings_hash(params)
    for leftover in (*out.glob(".*.part"), *folder.glob(".*.part"), *notes.glob(".*.part")):
        leftover.unlink()  # of a run that was killed
    known = {_number(path): note for path in notes.glob("shard-*.json") if (note := read_note(path))}
    wanted = arrange(_items(params, roots, trained_on, split), known, settings, params.shard_size)
    for path in (*folder.glob("shard-*.parquet"), *notes.glob("shard-*.json")):
        if _number(path) not in wanted:
            path.unlink()
    for number, items in sorted(wanted.items()):
        name = f"shard-{number:05d}"
        yield Task(items, roots, folder / f"{name}.parquet", notes / f"{name}.json", settings, params.selection)


def _number(shard: Path) -> int:
    return int(shard.stem.partition("-")[2])


def _items(params: Params, roots: dict[str, Path], trained_on: tuple[str, ...], split: str) -> list[str]:
    """Items `<data set>/<its split>/<scene>` of one of our splits; where there are too many, drawn by a fixed hash."""
    if split == "test":
        source = params.source
        theirs = (_held_out(params, source),) if source in trained_on else SPLITS
        items = [f"{source}/{word}/{scene}" for word in theirs for scene in _open(source, roots[source]).scenes(word)]
    else:
        items = [item for name in trained_on for item in _training_items(params, _open(name, roots[name]), name, split)]
    limit = params.limits.get(split)
    return items if limit is None else sorted(sorted(items, key=lambda item: derive(0, "limit", item))[:limit])


def _training_items(params: Params, data: Dataset, source: str, split: str) -> list[str]:
    """Its own train or val split; where val is held out as our test split, a share of train stands in for val."""
    if source != params.source or _held_out(params, source) != "val":
        return [f"{source}/{split}/{scene}" for scene in data.scenes(split)]
    scenes = data.scenes("train")
    return [f"{source}/train/{s}" for s in scenes if (derive(0, "val", s) % VAL_SHARE == 0) == (split == "val")]


def _held_out(params: Params, source: str) -> str:
    if params.held_out.get(source) not in ("val", "test"):
        raise UnusableInput(f"ingest.held_out must say of {source!r} whether 'val' or 'test' is measured on")
    return params.held_out[source]


def _settings_hash(params: Params) -> str:
    """Hash of what decides, besides the files, how items become rows: settings and code."""
    total = hashlib.sha256(orjson.dumps(asdict(params.selection), option=orjson.OPT_SORT_KEYS))
    package = Path(drivegen.__file__).parent
    for path in sorted([Path(__file__), *(path for pattern in CODE for path in package.glob(pattern))]):
        total.update(path.read_bytes())
    return total.hexdigest()


def make_shard(task: Task) -> Outcome:
    """The outcome of one shard, made now unless it stands already."""
    note = read_note(task.note)
    inputs = digest(path for item in task.items for path in _files(task, item))
    if note is None or not stands(note, task.settings, inputs, task.shard):
        task.note.unlink(missing_ok=True)
        scenarios, outcome = _make(task)
        task.shard.unlink(missing_ok=True)
        if scenarios:
            write_shard(task.shard, scenarios)
        size = task.shard.stat().st_size if scenarios else 0
        remembered = {"counts": {name: dict(numbers) for name, numbers in outcome.counts.items()}, "rejected": outcome.rejected}
        note = ShardNote(task.items, task.settings, inputs, size, remembered)
        write_note(task.note, note)
    counts = {name: Counter(numbers) for name, numbers in note.outcome["counts"].items()}
    return Outcome(counts, [tuple(row) for row in note.outcome["rejected"]])


def _files(task: Task, item: str) -> tuple[Path, ...]:
    source, split, scene = item.split("/", 2)
    try:
        return _open(source, task.roots[source]).files(split, scene)
    except UnusableInput:
        return ()  # reading will say what is missing


def _make(task: Task) -> tuple[list[Scenario], Outcome]:
    scenarios: list[Scenario] = []
    outcome = Outcome({}, [])
    for item in task.items:
        source, split, scene = item.split("/", 2)
        data = _open(source, task.roots[source])
        counts = outcome.counts.setdefault(data.description, Counter())
        try:
            log = data.read(split, scene)
            scenario = select(log, task.selection)
        except UnusableInput as error:
            counts["rejected"] += 1
            counts[f"rejected.{error.reason}"] += 1
            outcome.rejected.append((data.description, scene, error.reason, str(error)))
            continue
        scenarios.append(scenario)
        counts.update(_counts(log, scenario, task.selection))
    return scenarios, outcome


def _counts(log: RecordedLog, scenario: Scenario, settings: Settings) -> Counter[str]:
    """Numbers of one accepted scenario, to be summed."""
    counts = Counter(accepted=1, vehicles=len(scenario.vehicles), context_actors=len(scenario.context))
    counts["signals"] = len(scenario.signals)
    counts["dangling_lane_links"] = scenario.map.dangling
    counts["shorter_horizon"] = int(scenario.horizon < settings.horizon)
    counts["vehicles_seen_for_half"] = _seen_long(scenario)
    if scenario.log is not None:
        counts["scored_agent_steps"] = int(scenario.log.valid[:, 1:].sum())
    for source in SizeSource:
        counts[f"sizes.{source.name.lower()}"] = int((scenario.vehicles.size_source == source).sum())
    for name, value in scenario.notes.items():
        counts[f"noted.{name}"] = int(value) if value.isdecimal() else 1
    for word, tracks in log.skipped.items():
        counts[f"skipped_tracks.{word}"] = tracks
    return counts


def _summed(outcomes: list[Outcome]) -> Outcome:
    total = Outcome({}, [])
    for outcome in outcomes:
        for name, numbers in outcome.counts.items():
            total.counts.setdefault(name, Counter()).update(numbers)
        total.rejected += outcome.rejected
    return total


def _check(found: dict[str, Outcome]) -> None:
    for split in ("train", "test"):
        if not any(counts["accepted"] for counts in found[split].counts.values()):
            reasons = Counter(row[2] for row in found[split].rejected).most_common(3)
            said = ", ".join(f"{count} x {reason}" for reason, count in reasons) or "there are none"
            raise UnusableInput(f"no scene can be used as {split} scenario ({said}); see rejected.parquet or ingest.root")


def _write_tables(out: Path, found: dict[str, Outcome]) -> None:
    rejected = [(split, *row) for split, outcome in found.items() for row in outcome.rejected]
    numbers = [
        (split, name, word, count)
        for split, outcome in found.items()
        for name, counts in sorted(outcome.counts.items())
        for word, count in sorted(counts.items())
    ]
    words = pa.string()
    write_table(
        out / "rejected.parquet", _table(rejected, dict.fromkeys(("split", "source", "scene", "reason", "sentence"), words))
    )
    write_table(out / "counts.parquet", _table(numbers, {"split": words, "source": words, "name": words, "count": pa.int64()}))


def _table(rows: list[tuple[Any, ...]], columns: dict[str, pa.DataType]) -> pa.Table:
    return pa.table({name: pa.array([row[i] for row in rows], kind) for i, (name, kind) in enumerate(columns.items())})


if __name__ == "__main__":
    enter("ingest", Params, main)
