"""Planners given the true goal: side by side, beside anchors, with what they cost."""

from collections.abc import Mapping
from typing import Any

from drivegen.report import plots
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import NOT_MEASURED, Cell, Row, Table, measured, number, row, taken

PAPER_EPOCHS = 90
"""The paper's training; with less its planner is called under-trained."""

_COLUMNS = {
    "ade_best": "ADE, best [m]",
    "ade_mean": "ADE, mean [m]",
    "hidden.ade_best": "best, routes hidden [m]",
    "hidden.ade_mean": "mean, routes hidden [m]",
    "miss_rate": "missed goals",
    "goal_error": "goal error [m]",
    "acceleration": "acceleration, rms [m/s2]",
    "acceleration_distance": "its distance to the log's",
    "jerk": "jerk, rms [m/s3]",
    "jerk_distance": "its distance to the log's",
    "off_road": "off the road",
    "illegal": "illegal",
}

_NOTES = (
    "Validation tracks that move, each planned towards its own logged end. Distances are Wasserstein-1, of smoothed speeds. "
    "Illegal: by the checker's limits, all rules that need no other vehicle. A goal is missed if no sample ends within 2 m. "
    "Routes hidden: as where no route fits; route_fm then goes along a Bezier curve, the others are not told of routes anyhow. "
    "No residual: the base that meets both ends exactly, without anything learnt.",
)


def section(evidence: Evidence) -> Section:
    """The planners, side by side."""
    trained = {name: value for name, value in evidence.below("train_planner").items() if isinstance(value, Mapping)}
    lead = "Planners fill in motion between a vehicle's first state and its goal; here all are told the true goal."
    if not trained:
        return Section("planner", "Planners", lead, missing=not_measured("train_planner"))
    times = {name: evidence.costs.get(f"train_planner/{name}", {}) for name in trained}
    parts = (_quality(trained, evidence), _times(times))
    return Section("planner", "Planners", lead, parts, _curves(evidence, times))


def _quality(trained: Mapping[str, Mapping[str, Any]], evidence: Evidence) -> Table:
    """Planners in groups that were scored on the same tracks, each followed by its anchors; what was not trained says so."""
    groups: dict[tuple[Any, Any], list[str]] = {}
    for name, values in trained.items():
        groups.setdefault((values.get("scored_tracks"), values.get("scored_scenes")), []).append(name)
    rows: list[Row] = []
    for (tracks, scenes), names in groups.items():
        first = trained[names[0]]
        rows += [_line(_named(name, trained[name]), trained[name], "", tracks, scenes) for name in names]
        rows += [_line(text, first, prefix, tracks, scenes) for text, prefix in (("no residual", "base."), ("log", "log."))]
    missing = [Cell(NOT_MEASURED)] * (len(_COLUMNS) + 2)
    rows += [row(name, *missing, origin="ours") for name in evidence.planners if name not in trained]
    columns = ("planner", "steps", *_COLUMNS.values(), "tracks of scenes")
    return Table("planners", "Planners given the true goal", columns, tuple(rows), (*_NOTES, *evidence.trained_on))


def _line(text: str, values: Mapping[str, Any], prefix: str, tracks: Any, scenes: Any) -> Row:
    steps = number(values.get("steps")) if not prefix else "–"
    cells = [measured(dict(values), prefix + key, 3) if _has(prefix, key) else Cell("–") for key in _COLUMNS]
    return row(text, steps, *cells, f"{number(tracks)} of {number(scenes)}", origin="" if prefix else "ours")


_OWN = ("acceleration", "jerk", "off_road", "illegal")
"""What the log has, too: the rest would be against itself."""


def _has(prefix: str, key: str) -> bool:
    return not prefix or (key in _OWN if prefix == "log." else not key.startswith("hidden."))


def _named(name: str, values: Mapping[str, Any]) -> str:
    epochs = values.get("epochs")
    if name == "paper" and isinstance(epochs, float | int) and epochs < PAPER_EPOCHS:
        return f"paper (under-trained: {number(values.get('steps'))} steps, {epochs:.1f} of {PAPER_EPOCHS} epochs)"
    return name


def _times(times: Mapping[str, Mapping[str, float]]) -> Table:
    """Times differ from run to run: this table stands in the page only."""
    columns = ("planner", "training [CPU-s]", "training [GPU-s]", "trajectories per CPU-s", "trajectories per GPU-s")
    rows = tuple(
        row(
            name,
            taken(took, "training_cpu_seconds"),
            taken(took, "training_gpu_seconds"),
            _rate(took, "planning_cpu_seconds"),
            _rate(took, "planning_gpu_seconds"),
        )
        for name, took in times.items()
    )
    note = "Of the last run of the stage here. Planning is timed on the tracks of the table above, map and features included."
    return Table("planner-times", "What planners cost", columns, rows, (note,), repeatable=False)


def _rate(took: Mapping[str, float], time: str) -> str:
    return number(took["planned"] / took[time], 0) if took.get(time) and "planned" in took else taken(took, time)


def _curves(evidence: Evidence, times: Mapping[str, Mapping[str, float]]) -> tuple[Figure, ...]:
    """Mean ADE over training cost, all planners in one plot, and each planner's losses."""
    mine = {curve.title.partition("/")[2]: curve.columns for curve in evidence.curves if curve.title.startswith("train_planner/")}
    timed = bool(mine) and all(times.get(name, {}).get("training_cpu_seconds") for name in mine)
    lines = {}
    for name, columns in mine.items():
        if "ade" in columns and columns["step"]:
            scale = times[name]["training_cpu_seconds"] / columns["step"][-1] if timed else 1.0
            lines[name] = ([step * scale for step in columns["step"]], columns["ade"])
    cost = "training [CPU-s]" if timed else "steps"
    note = "Validation tracks, true goals; the weights are the averaged ones of each row of the training curve."
    figures = [Figure.svg("ADE over training cost", note, plots.lines(lines, cost, "mean ADE [m]"))] if lines else []
    for name, columns in mine.items():
        losses = {key: values for key, values in columns.items() if key != "ade"}
        figures.append(Figure.svg(f"Training: planner {name.replace('_', ' ')}", "", plots.curves(losses, next(iter(losses)))))
    return tuple(figures)
