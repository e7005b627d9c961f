"""What the same additions are worth to each method: its futures as they are, with either, with both."""

import numpy as np

from drivegen.core.intervals import Interval
from drivegen.core.methods import BOUND
from drivegen.metrics.pooled import pooled_mean
from drivegen.report.published.quality import cell
from drivegen.report.published.results import ADDED, OURS, DataSet, Pooled, resampling_of
from drivegen.report.table import Cell, Row, Table, decimals, row

_COLUMNS = {
    "min_sade": "min-sADE [m]", "min_sfde": "min-sFDE", "mean_sade": "mean-sADE", "mean_sfde": "mean-sFDE",
    "collision_per_vehicle": "in collision", "illegal_per_vehicle": "any violation",
}  # fmt: skip
_NOTES = (
    "Additions choose anew among a method's own futures, vehicle by vehicle, and change no trajectory. Checker: what is illegal "
    "gives way to the vehicle's own trajectory of the nearest length that is legal. Tempo: all get far, or none. In brackets: "
    "less the same futures as they are, with its interval.",
    "DriveGen makes its own additions while it draws goals and plans, with as many trajectories as it takes; these have no more "
    "to choose from than were drawn. Errors gain from what is taken out, too: who is off the road is seldom near the log.",
    "The log breaks rules of the checker as well: nobody can be asked for fewer violations than it has.",
)


def added(data: DataSet, pooled: Pooled, draws: int, rng: np.random.Generator) -> list[Table]:
    """The table, four rows a method, DriveGen and the log beside them; none where no additions were measured."""
    if not data.added:
        return []
    resampling = resampling_of(data, draws, rng)
    lines = [_whole(data, pooled, OURS)] if OURS in data.methods else []
    for name in _in_order(data):
        results, (method, _, additions) = data.added[name], name.partition("/")
        before = data.added[f"{method}/none"]
        differences = {
            metric: None if results is before else pooled_mean(results.values[metric] - before.values[metric], resampling)
            for metric in _COLUMNS
        }
        cells = [_cell(pooled[name][metric], differences[metric]) for metric in _COLUMNS]
        lines.append(row(f"{data.about[method].title}, {ADDED[additions]}", *cells, origin="ours"))
    lines += [_whole(data, pooled, name) for name in ("log",) if name in data.methods and data.about[name].kind == BOUND]
    title = f"What additions are worth to whom: {data.title}"
    return [Table(f"additions-{data.name}", title, ("", *_COLUMNS.values()), tuple(lines), (data.over, *_NOTES))]


def _in_order(data: DataSet) -> list[str]:
    """Names of `data.added`, methods in the tables' order, each as it is first."""
    return [f"{method}/{additions}" for method in data.about for additions in ADDED if f"{method}/{additions}" in data.added]


def _whole(data: DataSet, pooled: Pooled, name: str) -> Row:
    """A method with what is a part of it."""
    own = " + ".join(data.about[name].additions)
    cells = (cell(pooled[name].get(metric), 3 if "vehicle" in metric else 2) for metric in _COLUMNS)
    return row(data.about[name].title + (f", its own {own}" if own else ""), *cells, origin="ours")


def _cell(interval: Interval, less: Interval | None) -> Cell:
    text = f"{interval.value:.3f}" if abs(interval.value) < 1 else f"{interval.value:.2f}"
    if less is None:
        return Cell(text)
    value, low, high = (decimals(number, 3, "+") for number in (less.value, less.low, less.high))
    return Cell(text, f"{value}, {low} to {high}" if less.low < less.high else value)
