"""Figures of the paper's second table: drivers tuned on each method's scenes, tested on others, out of the stage `drive_tuned`.

Every figure is a ratio of sums over scenes, each the mean over policy seeds; intervals resample recordings, and all methods meet
the same draws, so differences are paired by scene, and by policy seed: of both rows those seeds count that both have.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, recording, resamplings
from drivegen.core.seeds import rng
from drivegen.metrics.ranking import interval
from drivegen.report.published.figures import as_columns

PRIMARY = "counted_rich"
"""The primary endpoint, declared before anything was measured: counted collisions among replayed neighbours, on test scenes that
are rich in encounters by their logs."""

BY_SEED = f"{PRIMARY}.seed_"
"""What the same of one policy seed is called, before the seed."""

REFERENCE = "dataset_longer"
"""The row that others are compared with: the same steps, without generated traffic."""

LOGS, AMOUNT = "log", "amount_"
"""The row of the tuning scenes' logs, and those of logs with so many futures of each (`amount_4`), compared with it, too."""

OURS, CASES, SHOWN = "drivegen", "corner_cases", "careful_teacher"
"""DriveGen's row; those of the same scenes with corner cases among them, and with as many of its own in which the teacher of the
corner cases shows how to drive. The second is compared with both others, too."""

ONE = "one"
METRICS = {
    "cr": ("cr", ONE),
    "dis": ("dis", ONE),
    "comfort": (ONE, "absolute_acceleration"),
    "comfort_signed": (ONE, "acceleration"),
    "counted": ("counted", ONE),
    PRIMARY: ("counted_rich", "rich"),
    "progress": ("dis", "logged"),
    "red_lights": ("red_run", "red_lights"),
    "off_road": ("off_road", ONE),
    "imposed_braking": ("imposed_braking", ONE),
}
"""By name what is summed above and below; of shared columns there is one for both kinds of neighbours."""

NEIGHBOURS = {"replayed": "", "reactive": "reactive."}
_SHARED = ("rich", "logged")

_RENAMED = {"drivegen_true_goals": "true_goals"}

Columns = dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Tests:
    """Runs of all policies on one data set.

    Attributes:
        data, protocol: what stands in the rows. recordings: (S,) of the scenes.
        values: of each (driver, method) and policy seed the columns (S,) by name, NaN where a scene has no such number.
        diversity: of each (driver, method, neighbours) Div with its interval, means over seeds.
    """

    data: str
    protocol: str
    recordings: Sequence[str]
    values: Mapping[tuple[str, str], Mapping[int, Columns]]
    diversity: Mapping[tuple[str, str, str], list[float]]


def read_tests(data: str, protocol: str, results: pa.Table, diversity: Mapping[str, Mapping[str, float | None]]) -> Tests:
    """From the rows of `drive_tuned` and its JSON of diversities, `<driver>/<method>/<seed>/<neighbours>`."""
    names = ("driver", "method", "seed", "metric")
    coded = {name: results[name].combine_chunks().dictionary_encode() for name in names}
    groups, of = np.unique([column.indices.to_numpy() for column in coded.values()], axis=1, return_inverse=True)
    ids, place = np.unique(results["scenario"].to_numpy(), return_inverse=True)
    value, values = results["value"].to_numpy(), dict[tuple[str, str], dict[int, Columns]]()
    for rows, group in zip(_members(of), groups.T, strict=True):
        driver, method, seed, metric = (coded[name].dictionary[code].as_py() for name, code in zip(names, group, strict=True))
        column = np.full(len(ids), np.nan)
        column[place[rows]] = value[rows]
        of_seeds = values.setdefault((driver, _RENAMED.get(method, method)), {})
        of_seeds.setdefault(seed, {ONE: np.ones(len(ids))})[metric] = column
    for columns in (columns for of_seeds in values.values() for columns in of_seeds.values()):
        for prefix in NEIGHBOURS.values():
            columns[f"{prefix}counted_rich"] = columns[f"{prefix}counted"] * columns["rich"]
    return Tests(data, protocol, [recording(name) for name in ids], values, _diversities(diversity))


def _members(of: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """The rows of each group, where `of` is the group of each row."""
    return np.split(np.argsort(of, kind="stable"), np.cumsum(np.bincount(of))[:-1])


def _diversities(diversity: Mapping[str, Mapping[str, float | None]]) -> dict[tuple[str, str, str], list[float]]:
    by_seed: dict[tuple[str, str, str], list[list[float]]] = {}
    for name, entry in diversity.items():
        driver, method, _, neighbours = name.split("/")
        key = (driver, _RENAMED.get(method, method), neighbours)
        by_seed.setdefault(key, []).append([_number(entry[end]) for end in ("value", "low", "high")])
    return {key: np.mean(several, axis=0).tolist() for key, several in by_seed.items()}


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


def driver_rows(tests: Tests, draws: int, seed: int) -> Iterator[dict[str, Any]]:
    """Every figure, and how far it is from other rows' (`_compared`), `<metric>.minus_<row>`, by the seeds that both have.

    n is the number of scenes that are summed up: of the primary endpoint the rich ones, of red lights those that met some.
    """
    resampled = resamplings(tests.recordings, draws, rng(seed, "drivers", tests.data))
    times = np.concatenate([np.ones((1, len(tests.recordings))), resampled])
    for (driver, method), seeds in tests.values.items():
        for neighbours, prefix in NEIGHBOURS.items():
            about: dict[str, Any] = {"data": tests.data, "protocol": tests.protocol, "driver": driver, "method": method}
            about |= {"neighbours": neighbours, "n": 0, "seeds": len(seeds)}
            for metric in METRICS:
                if metric == "imposed_braking" and not prefix:
                    continue
                about["n"] = int(np.count_nonzero(_sides(seeds.values(), metric, prefix)[1]))
                yield about | {"metric": metric} | as_columns(interval(_figure(seeds.values(), metric, prefix, times)))
                for other in _compared(method, metric):
                    theirs = tests.values.get((driver, other), {})
                    if both := [one for one in seeds if one in theirs]:
                        mine, its = (_figure([of[one] for one in both], metric, prefix, times) for of in (seeds, theirs))
                        less = as_columns(interval(mine - its))
                        yield about | {"metric": f"{metric}.minus_{other}", "seeds": len(both)} | less
            about["n"] = len(tests.recordings)
            for one, columns in sorted(({} if prefix else seeds).items()):
                (value,) = _figure([columns], PRIMARY, prefix, times[:1]).tolist()
                if np.isfinite(value):  # some scene is rich
                    by_seed = {"metric": f"{BY_SEED}{one}", "value": value, "low": None, "high": None, "seeds": 1}
                    yield about | by_seed | {"n": int(columns["rich"].sum())}
            yield about | {"metric": "div"} | as_columns(Interval(*tests.diversity[driver, method, neighbours]))


def _compared(method: str, metric: str) -> list[str]:
    """The rows from which a row's distance is published."""
    own = {CASES: [OURS, SHOWN], SHOWN: [OURS]}.get(method, [LOGS] if method.startswith(AMOUNT) else [])
    return [*([REFERENCE] if method != REFERENCE else []), *(own if metric == PRIMARY else [])]


def _figure(seeds: Iterable[Columns], metric: str, prefix: str, times: NDArray[np.floating]) -> NDArray[np.float64]:
    """(1 + draws,) the metric, first as it is, of the mean over seeds scene by scene."""
    above, below = _sides(seeds, metric, prefix)
    sums = times @ above, times @ below
    figure: NDArray[np.float64] = np.abs(np.divide(*sums, out=np.full(len(times), np.nan), where=sums[1] != 0))
    return figure


def _sides(seeds: Iterable[Columns], metric: str, prefix: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What is summed above and below, (S,) each, 0 where one of both is not known."""
    names, columns = METRICS[metric], list(seeds)
    above, below = (
        _means([of_seed[name if name in (ONE, *_SHARED) else f"{prefix}{name}"] for of_seed in columns]) for name in names
    )
    finite = np.isfinite(above) & np.isfinite(below)
    return np.where(finite, above, 0.0), np.where(finite, below, 0.0)


def _means(of_seeds: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """(S,) over the seeds that have the number, NaN where none has."""
    there = np.isfinite(of_seeds)
    count = there.sum(axis=0)
    means = np.full(len(count), np.nan)
    means[count > 0] = np.where(there, of_seeds, 0.0).sum(axis=0)[count > 0] / count[count > 0]
    return means
