"""Stage ingest: recordings to shards of scenarios, each accepted or rejected with a counted reason.

argv: the embedded corpus, the folder of scenarios (gets {train,val,test}/shard-*.parquet, rejected.parquet,
counts.parquet and notes/), the counts (JSON). The folder is kept between runs: shards that would be made the same again
are left alone, so more recordings mean more shards and a kill costs one.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import SPLITS
from drivegen.core.settings import Count, Index
from drivegen.ingest.admission import Admission, accounts, count_reasons, require_scenarios
from drivegen.ingest.selection import Settings
from drivegen.ingest.shards import make_shard, note_if_empty, plan_shards
from drivegen.ingest.sources import Sources
from drivegen.ingest.splits import CORPUS, Plan, items, once, trained_on, unseen
from drivegen.store.files import write_json, write_table
from stages._door import spread


@dataclass(frozen=True)
class Params:
    """Section `ingest`.

    Attributes:
        source: the data set that is regenerated and measured on. root: its folder; the corpus has its own.
        train_on: the data sets that models are trained on. roots: folders of those that are neither source nor corpus.
        held_out, limits, recordings: see `ingest.splits.Plan`.
        fewest_tracks: with fewer usable training tracks a data set is not trained on, but the corpus.
        shard_size: scenarios to a file.
        selection: see `ingest.selection.Settings`. horizons: the horizon of data sets whose recordings are short [steps], in
            place of the selection's: errors over horizons of different length are not averaged together.
    """

    workers: Count
    source: str
    root: str
    train_on: tuple[str, ...]
    roots: dict[str, str]
    held_out: dict[str, str]
    fewest_tracks: Index
    limits: dict[str, int | None]
    recordings: tuple[str, ...]
    shard_size: Count
    selection: Settings
    horizons: dict[str, int]


def main(params: Params, corpus: Path, out: Path, metrics: Path) -> dict[str, float]:
    """Plan the shards, make those that are not there yet, count everything."""
    sources = _sources(params, corpus)
    names, note = trained_on(params.train_on, sources.open, sources.settings, params.fewest_tracks)
    admissions = _make_shards(params, sources, Plan(params.source, names, params.held_out, params.limits, params.recordings), out)
    for name, table in accounts(admissions).items():
        write_table(out / f"{name}.parquet", table)
    rejected = out / "rejected.parquet"
    require_scenarios(admissions, f"see {rejected}, ingest.root and ingest.held_out")
    if rows := [row for admission in admissions.values() for row in admission.rejected]:
        print(f"ingest: {len(rows)} scenes rejected ({count_reasons(rows)}): {rejected} says why of each")
    for split in SPLITS:
        note_if_empty(out / split, params.source)
    described = ", ".join(sources.open(name).description for name in names)
    counts = {split: admission.counts for split, admission in admissions.items()}
    write_json(metrics, {"trained_on": described, "note": note, "splits": counts})
    return {"scenarios": float(sum(admission.accepted for admission in admissions.values()))}


def _sources(params: Params, corpus: Path) -> Sources:
    """Every data set that the parameters name, the corpus among them."""
    plugins.load("datasets", params.source)  # a misspelt one is the first thing to say
    own = {} if params.source == CORPUS else {params.source: Path(params.root)}
    folders = {**{name: Path(root) for name, root in params.roots.items()}, **own, CORPUS: corpus}
    if unknown := [name for name in params.train_on if name not in folders]:
        raise UnusableInput(f"ingest.train_on names {unknown[0]!r}, but ingest.roots has no folder for it")
    return Sources(folders, params.selection, params.horizons)


def _make_shards(params: Params, sources: Sources, plan: Plan, out: Path) -> dict[str, Admission]:
    """What became of all recordings, by split."""
    settings = sources.digest()
    chosen, shown = unseen({split: items(plan, sources.open, split) for split in SPLITS})
    chosen, again = once(chosen)
    tasks = {split: list(plan_shards(chosen[split], sources, settings, params.shard_size, out, split)) for split in SPLITS}
    admissions = {split: Admission() for split in SPLITS}
    for split in SPLITS:
        for item in shown[split]:
            said = f"{item}: the test split shows the same cars, so nobody learns from it"
            _leave_out(sources, admissions[split], item, UnusableInput(said, reason="shown-in-test"))
        for item in again[split]:
            said = f"{item}: another scene has this name, which is the scenario's id: remove or rename one of them"
            _leave_out(sources, admissions[split], item, UnusableInput(said, reason="duplicate-id"))
    of_task = {task.note: admissions[split] for split in SPLITS for task in tasks[split]}
    for task, admission in spread(make_shard, [task for split in SPLITS for task in tasks[split]], params.workers, "ingest"):
        of_task[task.note].add(admission)
    return admissions


def _leave_out(sources: Sources, admission: Admission, item: str, why: UnusableInput) -> None:
    data, _, scene = sources.scene(item)
    admission.reject(data, scene, why)
