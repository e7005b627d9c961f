"""Whether generated traffic ranks drivers as real roads do: rows and tables out of the results of stage `rank`."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, recording
from drivegen.core.seeds import rng
from drivegen.metrics.ranking import Rates, agreements, ceiling, interval
from drivegen.report.averaged import over_recordings
from drivegen.report.published.figures import as_columns
from drivegen.report.table import Row, Table, estimate, row

LOG, OURS, HALVES = "log", "drivegen", "half_of_log"
AHEAD = ("drivegen_ahead", "drivegen_ahead_low", "drivegen_ahead_high")
MEASURES = {"counted": "counted collisions", "near_miss": "time to collision below 1.5 s"}

REAL = ("ngsim", "argoverse2_sensor")
"""Data sets whose logs are recordings of real roads, which say what order is right."""

_NOTHING = Interval(np.nan, np.nan, np.nan)


@dataclass(frozen=True)
class Traffic:
    """The runs of all drivers in one kind of traffic: `made_from` a data set by `method`, and what happened by measure."""

    made_from: str
    method: str
    rates: Mapping[str, Rates]


def kinds_of(made_from: str, results: pa.Table, left_out: Collection[str] = ()) -> list[Traffic]:
    """The kinds of traffic among the rows of one run of stage `rank`; drivers that are `left_out` are not ranked."""
    results = results.filter(pc.invert(pc.is_in(results["driver"], pa.array(left_out, pa.string()))))
    columns = {name: np.asarray(results[name].to_pylist(), object) for name in ("method", "driver", "scenario", "metric")}
    value = results["value"].to_numpy()
    methods = dict.fromkeys(columns["method"].tolist())
    return [
        Traffic(made_from, method, {measure: _rates(columns, value, method, measure) for measure in MEASURES})
        for method in methods
    ]


def _rates(columns: Mapping[str, NDArray[Any]], value: NDArray[np.float64], method: str, measure: str) -> Rates:
    chosen = (columns["method"] == method) & (columns["metric"] == measure)
    drivers, driver = np.unique(columns["driver"][chosen].astype(str), return_inverse=True)
    scenes, scene = np.unique(columns["scenario"][chosen].astype(str), return_inverse=True)
    table = np.full((len(drivers), len(scenes)), np.nan)
    table[driver, scene] = value[chosen]
    return Rates(table, [recording(name) for name in scenes])


def ranking_rows(kinds: Sequence[Traffic], draws: int, seed: int) -> Iterator[dict[str, Any]]:
    """A row for each real data set, measure and kind of traffic: tau with its interval, and how far DriveGen's is ahead of it.

    The row of a real data set with itself is the ceiling: tau between halves of its recordings.
    """
    for real in (kind for kind in kinds if kind.made_from in REAL and kind.method == LOG):
        others = [kind for kind in kinds if kind is not real]
        for measure in MEASURES:
            random = rng(seed, "ranking", real.made_from, measure)
            taus = agreements(real.rates[measure], [kind.rates[measure] for kind in others], draws, random)
            halves = interval(ceiling(real.rates[measure], draws, random))
            yield _row(real, real, measure, halves, _NOTHING)
            ours = {kind.made_from: tau for kind, tau in zip(others, taus, strict=True) if kind.method == OURS}
            for kind, tau in zip(others, taus, strict=True):
                rival = kind.made_from in ours and kind.method != OURS
                ahead = interval(ours[kind.made_from] - tau) if rival else _NOTHING
                yield _row(real, kind, measure, interval(tau), ahead)


def _row(real: Traffic, kind: Traffic, measure: str, tau: Interval, ahead: Interval) -> dict[str, Any]:
    rates = real.rates[measure]
    return {
        "real": real.made_from,
        "made_from": kind.made_from,
        "method": kind.method if kind is not real else HALVES,
        "measure": measure,
        **as_columns(tau),
        **as_columns(ahead, AHEAD),
        "drivers": len(rates.values),
        "real_scenes": len(rates.recordings),
        "real_recordings": len(set(rates.recordings)),
        "scenes": len(kind.rates[measure].recordings),
    }


def ranking_table(rows: Sequence[Mapping[str, Any]], titles: Mapping[str, str]) -> Table:
    """All rows as one table; `titles` of methods in words."""
    lines = [_line(each, titles) for each in rows]
    of_roads = dict.fromkeys(
        f"Real roads of {one['real']}: {one['real_scenes']} scenes. {over_recordings(one['real_recordings'])}" for one in rows
    )
    return Table(
        "drivers-ranking",
        "Does traffic rank drivers as real roads do?",
        ("real roads", "traffic", "made from", "by", "tau", "DriveGen less this"),
        tuple(lines),
        (
            "Kendall's tau-b between both orders of the same sound and faulty drivers, neighbours replayed (drivers that do the "
            "same as another by other code are not ranked); 95 % intervals over recordings and drivers. *Half of the "
            "recordings*: what one half of the real ones says of the other; two real data sets of full size would agree better.",
            *of_roads,
        ),
    )


def _line(each: Mapping[str, Any], titles: Mapping[str, str]) -> Row:
    method = {LOG: "logs", HALVES: "half of the recordings"}.get(each["method"]) or titles[each["method"]]
    measure, tau = MEASURES[each["measure"]], estimate(each, 2)
    return row(each["real"], method, each["made_from"], measure, tau, estimate(each, 2, AHEAD))
