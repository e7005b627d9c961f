"""The published tables: methods in rows, the paper's figures beside ours and marked as theirs."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from drivegen.core.intervals import Interval, recording
from drivegen.core.methods import ABLATION, BOUND, NO_TRAFFIC
from drivegen.core.methods import OURS as OUR_KIND
from drivegen.metrics.pooled import Resampling, pooled_mean, rank_correlation
from drivegen.metrics.realism import WEIGHTS
from drivegen.report import paper
from drivegen.report.averaged import seconds
from drivegen.report.columns import EDGES, EDGES_MEAN, FIVE, FLOOR, MARKS, SAFETY, badness, mark
from drivegen.report.published.figures import as_columns
from drivegen.report.published.results import ADDED, BOTH, OURS, DataSet, Pooled, resampling_of
from drivegen.report.sections.trust import REALISM, has, readings
from drivegen.report.table import NOT_MEASURED, Cell, Row, Table, estimate, row

HEADS = ("min-sADE [m] \u2193", "min-sFDE \u2193", "mean-sADE \u2193", "mean-sFDE \u2193", "diversity \u2192 1")

_CAUTION = "So few scenes show that it runs; they rank nothing, and intervals over so few are too narrow."
"""Under every table of a data set that is given scene by scene."""


def tables(data: DataSet, pooled: Pooled, draws: int, rng: np.random.Generator) -> list[Table]:
    """The paper's table I, paired differences, and what the paper leaves out."""
    variants = [name for name in data.methods if data.about[name].kind == OUR_KIND and name != OURS]
    resampling = resampling_of(data, draws, rng)
    pairs = [_paired(data, name, resampling) for name in (OURS, *variants)]
    made_tables = [_quality(data, pooled), *pairs, *_trust(data, pooled)]
    made_tables = [replace(table, notes=(data.over, *table.notes)) for table in made_tables]
    return [*made_tables, _by_scene(data)] if data.by_scene or data.left_out else made_tables


def few(data: DataSet, of_data: Sequence[Table]) -> list[Table]:
    """The tables, with a word of caution under each where a data set has few scenes."""
    return [replace(table, notes=(*table.notes, _CAUTION)) if data.by_scene else table for table in of_data]


def transfer(one: DataSet, pooled_one: Pooled, other: DataSet, pooled_other: Pooled) -> Table:
    """Whether both data sets put the methods in the same order: Spearman's rho, per column of the paper."""
    shared = pooled_one.keys() & pooled_other.keys()
    methods = [name for name, method in one.about.items() if name in shared and method.kind != BOUND]
    anchors = [name for name in methods if one.about[name].kind in _ANCHORS]
    rivals = [name for name in methods if name not in anchors]
    lines = []
    for metric, head in zip(FIVE, HEADS, strict=True):
        both = (_order(group, metric, pooled_one, pooled_other) for group in (methods, rivals))
        lines.append(row(head.split(" ")[0], *(text for found in both for text in found)))
    title = f"Order of the methods: {one.title} against {other.title}"
    heads = ("", "Spearman's rho", "methods", "without anchors", "methods")
    named = " and ".join(one.about[name].title for name in anchors)
    notes = (
        "1: the same order; 0: none in common. The log's own row is left out; diversity is ranked by its distance from 1.",
        f"Anchors, left out on the right, are {named}: what is far off on every data set makes orders alike by itself.",
    )
    return Table(f"transfer-{one.name}-{other.name}", title, heads, tuple(lines), notes)


_ANCHORS = (NO_TRAFFIC, ABLATION)
"""No traffic, and DriveGen with a part taken out: neither is a method that anybody proposes."""


def _order(methods: Sequence[str], metric: str, one: Pooled, other: Pooled) -> tuple[str, str]:
    """Spearman's rho of those of the methods that both have, and how many these are."""
    measured = [m for m in methods if metric in one[m] and metric in other[m]]
    a, b = (np.array([badness(metric, pooled[m][metric].value) for m in measured]) for pooled in (one, other))
    rho = rank_correlation(a, b)
    return f"{rho:.2f}" if np.isfinite(rho) else NOT_MEASURED, str(len(measured))


def training(less: DataSet, more: DataSet, draws: int, rng: np.random.Generator) -> Table:
    """The scenes and runs that both have, by models that learnt from less and from more: errors of each, the difference.

    Where there are none the table has no rows and says what is missing.
    """
    name, title = f"training-{more.name}", f"Trained on less and on more: {more.title}"
    heads = tuple(f"{head} {which}" for head in ("min-sADE", "mean-sADE") for which in ("less", "more", "more - less"))
    first, second = (next(iter(data.methods.values())).scenarios for data in (less, more))
    shared = sorted(set(first) & set(second))
    columns = [[names.index(scene) for scene in shared] for names in (first, second)]
    runs = sorted(set(less.runs) & set(more.runs))
    if not (shared and runs):
        return Table(name, title, ("", *heads), (), (_nothing_shared(less, more, bool(shared)),))
    trained = [[data.runs.index(run) for run in runs] for data in (less, more)]
    resampling = Resampling.of(runs, [recording(scene) for scene in shared], draws, rng)
    lines = []
    for method in [name for name in less.generators if name in more.methods]:
        before, after = (
            {metric: data.methods[method].values[metric][np.ix_(rows, at)] for metric in ("min_sade", "mean_sade")}
            for data, rows, at in zip((less, more), trained, columns, strict=True)
        )
        cells = [
            cell(pooled_mean(values, resampling))
            for metric in before
            for values in (before[metric], after[metric], after[metric] - before[metric])
        ]
        lines.append(row(less.about[method].title, *cells, origin="ours"))
    count = len({recording(scene) for scene in shared})
    notes = (f"{len(shared)} scenes of {count} recordings that both have. Less: {less.trained_on} More: {more.trained_on}",)
    return Table(name, title, ("", *heads), tuple(lines), notes)


def _nothing_shared(less: DataSet, more: DataSet, scenes: bool) -> str:
    if not scenes:
        return f"Nothing to compare: {less.title} and {more.title} have no scene in common."
    ran = " and ".join(f"{data.title} with {', '.join(run.folder for run in data.runs)}" for data in (less, more))
    return f"Nothing to compare: {ran} have no run in common; `make tables` runs those that are missing."


def _quality(data: DataSet, pooled: Pooled) -> Table:
    columns = (*FIVE, "spread")
    ours = [
        row(label(m, data, pooled), _chosen(data, m), *(cell(pooled.get(m, {}).get(metric)) for metric in columns), origin="ours")
        for m in data.rows
    ]
    theirs = [
        row(name, paper.MARK, *(f"{v:.2f}" for v in values), "\u2013", origin="paper") for name, values in paper.QUALITY.items()
    ]
    seeds = f"{len(data.seeds)} training by {len(data.sampling_seeds)} sampling seeds"
    notes = (
        " ".join(filter(None, [f"{data.title}; {data.scenes} scenes, {seeds}.", data.tracks, data.trained_on])),
        "Intervals: bootstrap over groups of recordings that share vehicles, crossed with training and with sampling seeds; "
        "of diversity, over such groups, widened to hold every run's.",
        "All are given map and first frame, where data has signals with their states then, and nothing of what follows: a signal "
        "is taken to stay as it is, who is on foot or bicycle to keep its velocity for 2 s. Nobody is charged for a later red.",
        "DriveGen's samples of a scene have tempos spread evenly, and SceneTransformer draws without repetition: the nearest of "
        "ten is a little nearer so than of ten that know nothing of each other, as all others draw.",
        "The paper's rows were measured on other data by others: they cannot be compared with ours.",
        "Diversity is the paper's ratio of two sets of scenes, in which what never varies may have 1. Within a scene: how far "
        "two samples are apart, the mean over steps and vehicles; it has no best value.",
        *MARKS,
    )
    heads = ("", "goals chosen by", *HEADS, "within a scene [m]")
    return Table(f"quality-{data.name}", f"Table I. Scenario quality: {data.title}", heads, (*ours, *theirs), notes)


def _paired(data: DataSet, mine: str, resampling: Resampling) -> Table:
    """One of ours less each other method, and less it with our additions, scene by scene and seed by seed: negative is better."""
    ours, lines = data.methods.get(mine), []
    others = {name: data.about[name].title for name in data.generators if name != mine}
    with_both = {f"{name}/{BOTH}": f"{title}, {ADDED[BOTH]}" for name, title in others.items() if f"{name}/{BOTH}" in data.added}
    for method, title in {**others, **with_both}.items():
        other = data.every[method]
        cells = [
            cell(pooled_mean(ours.values[metric] - other.values[metric], resampling)) if ours else Cell(NOT_MEASURED)
            for metric in FIVE[:4]
        ]
        lines.append(row(title, *cells, origin="ours"))
    name, whose = f"paired-{data.name}" if mine == OURS else f"paired-{mine}-{data.name}", data.about[mine].title
    title, note = f"{whose} less the others, paired: {data.title}", f"Below zero {whose} is better."
    additions = f"{ADDED[BOTH].capitalize()}: with the additions that DriveGen has by itself (`additions-{data.name}`)."
    return Table(name, title, (f"{whose} less", *HEADS[:4]), tuple(lines), (note, *([additions] if with_both else [])))


def _trust(data: DataSet, pooled: Pooled) -> list[Table]:
    """What the paper leaves out, in the report's words."""
    safety = {**SAFETY, "illegal_per_scene": "scenes with any", **EDGES}
    note = "Shares of vehicles, and of scenes, that the legal checker objects to."
    tables = [_plain(f"safety-{data.name}", "Safety of what is generated", safety, data, pooled, (note, EDGES_MEAN))]
    for one in readings(name for metrics in pooled.values() for name in metrics):
        notes = (f"{one.note} {_weights()}" if one.name == "realism" else one.note,)
        tables.append(_plain(f"{one.name}-{data.name}", one.title, one.columns, data, pooled, notes))
    return tables


def _weights() -> str:
    named = (f"{words} {WEIGHTS[name.removeprefix('realism.')]:.3f}" for name, words in REALISM.items() if "." in name)
    return f"Weights: {', '.join(named)}."


def _plain(name: str, title: str, columns: Mapping[str, str], data: DataSet, pooled: Pooled, notes: tuple[str, ...]) -> Table:
    lines = [
        row(
            label(m, data, pooled),
            *(cell(pooled.get(m, {}).get(c), 3) if has(method, c) else "–" for c in columns),
            origin="ours",
        )
        for m, method in data.rows.items()
    ]
    return Table(name, f"{title}: {data.title}", ("", *columns.values()), tuple(lines), notes)


def _by_scene(data: DataSet) -> Table:
    """Scenes that are too few to average, and those of another length, each a row: the errors of each method, mean over seeds."""
    methods = [name for name in data.rows if name in data.methods]
    lines: list[Row] = []
    for group in (data.methods if data.by_scene else {}, data.left_out):
        for n, scene in enumerate(group[methods[0]].scenarios if group else ()):
            both = [[float(np.nanmean(group[m].values[k][:, n])) for k in ("min_sade", "mean_sade")] for m in methods]
            length = f"{scene} ({seconds(int(group[methods[0]].values['steps'][0, n]))} s)" if data.left_out else scene
            lines.append(row(length, *(f"{low:.2f} / {mean:.2f}" for low, mean in both), origin="ours"))
    notes = ("min-sADE / mean-sADE [m].", *((data.over,) if data.left_out else ()))
    return Table(
        f"scenes-{data.name}", f"Scene by scene: {data.title}", ("", *(data.about[m].title for m in methods)), tuple(lines), notes
    )


def label(method: str, data: DataSet, pooled: Pooled) -> str:
    """The method in words, marked where constant velocity is no worse."""
    mine, floor = (
        {metric: interval.value for metric, interval in pooled.get(m, {}).items() if metric in ("min_sade", "mean_sade")}
        for m in (method, FLOOR)
    )
    return data.about[method].title + mark(method, data.about[method], mine, floor)


def _chosen(data: DataSet, method: str) -> str:
    return data.methods[method].chosen_by if method in data.methods else NOT_MEASURED


def cell(interval: Interval | None, digits: int = 2) -> Cell:
    """A figure with its interval, if it has one."""
    if interval is None or not np.isfinite(interval.value):
        return Cell(NOT_MEASURED)
    return estimate(as_columns(interval), digits)
