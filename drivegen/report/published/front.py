"""Error against diversity: what DriveGen's temperature trades, as a table and as a curve, beside the other methods."""

from collections.abc import Mapping, Sequence

import numpy as np

from drivegen.core.intervals import Interval
from drivegen.core.methods import ABLATION
from drivegen.metrics.front import on_front
from drivegen.report import plots
from drivegen.report.columns import FIVE
from drivegen.report.published.quality import HEADS, cell, label
from drivegen.report.published.results import OURS, DataSet, Pooled, Results
from drivegen.report.table import Cell, Table, row


def front(data: DataSet, at: Mapping[float, Results], pooled: Pooled, in_use: float | None) -> Table:
    """DriveGen at every temperature of its goals, the one `in_use` (None if unknown) among them, the others as they are.

    The front is bold: no other row has a lower mean-sADE and a diversity as near to 1, or the reverse.
    """
    curve = {t: {metric: _one_seed(results, metric) for metric in FIVE} for t, results in sorted(at.items())}
    rows_of = {f"DriveGen, temperature {t:g}": cells for t, cells in curve.items()}
    methods = [name for name in data.generators if name in pooled]
    names = {m: label(m, data, pooled) for m in methods}
    if OURS in names:
        names[OURS] = f"DriveGen, temperature {in_use:g} (in use)" if in_use is not None else "DriveGen, temperature in use"
    rows_of |= {names[m]: {metric: pooled[m].get(metric) for metric in FIVE} for m in methods}
    error, diversity = (
        np.array([np.nan if (point := cells[metric]) is None else point.value for cells in rows_of.values()])
        for metric in ("mean_sade", "diversity")
    )
    bold = on_front(error, diversity)
    lines = [
        row(Cell(name, best=bool(best)), *(cell(cells[metric]) for metric in FIVE), origin="ours")
        for (name, cells), best in zip(rows_of.items(), bold, strict=True)
    ]
    notes = (
        f"One run (seeds {data.runs[0].folder} of training and sampling) at each temperature; the temperature in use was chosen "
        f"on the validation split, and its row is of {'all runs' if len(data.runs) > 1 else 'that run'}.",
        "Bold: on the front, that is, no other row has a lower mean-sADE and a diversity as near to 1, or the reverse.",
        *_beaten(
            [names.get(OURS, ""), *(f"DriveGen, temperature {t:g}" for t in curve)],
            {name: bool(best) for name, best, both in zip(rows_of, bold, error + diversity, strict=True) if np.isfinite(both)},
        ),
    )
    picture = _picture(data, at, in_use)
    title = f"Error against diversity: {data.title}"
    return Table(f"front-{data.name}", title, ("", *HEADS), tuple(lines), notes, picture=picture)


def _beaten(ours: Sequence[str], bold: Mapping[str, bool]) -> list[str]:
    """Which of DriveGen's rows another one beats, in a sentence; `bold` holds those that were measured."""
    measured = [name for name in ours if name in bold]
    beaten = [name.removeprefix("DriveGen, ") for name in measured if not bold[name]]
    if not beaten:
        return ["All of DriveGen's rows are on the front."] if measured else []
    return [f"Not on the front, so another row is no worse in either and better in one: DriveGen at {'; '.join(beaten)}."]


def _picture(data: DataSet, at: Mapping[float, Results], in_use: float | None) -> bytes:
    """(diversity, mean-sADE) of the first training seed: DriveGen along its temperatures, every other method a point.

    What goes at random is so far off that nothing else could be told apart, and is left out.
    """
    seeds = dict(at)
    if in_use is not None and OURS in data.methods:
        seeds[in_use] = data.methods[OURS]
    curve = []
    for temperature in sorted(seeds):
        error, diversity = (_one_seed(seeds[temperature], metric) for metric in ("mean_sade", "diversity"))
        if error is not None and diversity is not None:
            curve.append((f"{temperature:g}", diversity.value, error.value))
    points = {}
    for name, method in data.generators.items():
        if name == OURS or method.kind == ABLATION or not method.competes:
            continue
        error, diversity = (_one_seed(data.methods[name], metric) for metric in ("mean_sade", "diversity"))
        if error is not None and diversity is not None:
            points[method.title] = (diversity.value, error.value)
    return plots.front(curve, points)


def _one_seed(results: Results, metric: str) -> Interval | None:
    """Of the first training seed, without an interval, for it is a point of a curve."""
    if metric in results.sets:
        return Interval(results.sets[metric][0].value, np.nan, np.nan)
    values = results.values.get(metric)
    return None if values is None else Interval(float(np.nanmean(values[0])), np.nan, np.nan)
