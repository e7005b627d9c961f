"""Figures of the paper's second table: drivers tuned on each method's scenes, tested on others, out of the stage `drive_tuned`.

Every figure but Div is a ratio of sums over scenes and policy seeds: those seeds that all rows of a driver have, in a difference
those that both rows have. Intervals resample recordings, crossed with policy seeds, and all methods meet the same draws, so
differences are paired by scene and by policy seed. Div is a number of a whole set of scenes: the mean of the policy seeds', from
the lowest end of their intervals over recordings to the highest.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, counts, recording, resamplings
from drivegen.core.seeds import rng
from drivegen.metrics.driving import NEIGHBOURS
from drivegen.metrics.pooled import envelope
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

_SHARED = ("rich", "logged")

_RENAMED = {"drivegen_true_goals": "true_goals"}

Columns = dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Tests:
    """Runs of all policies on one data set.

    Attributes:
        data, protocol: what stands in the rows. recordings: (S,) of the scenes.
        values: of each (driver, method) and policy seed the columns (S,) by name, NaN where a scene has no such number.
        diversity: of each (driver, method, neighbours) and policy seed Div with the ends of its interval.
    """

    data: str
    protocol: str
    recordings: Sequence[str]
    values: Mapping[tuple[str, str], Mapping[int, Columns]]
    diversity: Mapping[tuple[str, str, str], Mapping[int, list[float]]]

    def shared_seeds(self, driver: str, method: str) -> list[int]:
        """The policy seeds of a row that all rows of its driver have; all of its own where they have none in common."""
        mine = self.values[driver, method]
        every = [set(seeds) for (who, _), seeds in self.values.items() if who == driver]
        return sorted(set.intersection(*every)) or sorted(mine)


class Draws:
    """How often scenes and policy seeds come: first once each, then in each of D bootstrap draws, the same for all rows."""

    def __init__(self, tests: Tests, draws: int, seed: int) -> None:
        """D = `draws`, or 0 of one recording."""
        resampled = resamplings(tests.recordings, draws, rng(seed, "drivers", tests.data))
        self.scenes = np.concatenate([np.ones((1, len(tests.recordings))), resampled])
        self._policies: dict[tuple[int, ...], NDArray[np.float64]] = {}
        self._stream = seed, "drivers", tests.data, "policies"

    def policies(self, seeds: Sequence[int]) -> NDArray[np.float64]:
        """(1 + D, K) of K policy seeds."""
        key = tuple(seeds)
        if key not in self._policies:
            resampled = counts(len(key), len(self.scenes) - 1, rng(*self._stream, *key))
            self._policies[key] = np.concatenate([np.ones((1, len(key))), resampled])
        return self._policies[key]


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


def _diversities(diversity: Mapping[str, Mapping[str, float | None]]) -> dict[tuple[str, str, str], dict[int, list[float]]]:
    by_seed: dict[tuple[str, str, str], dict[int, list[float]]] = {}
    for name, entry in diversity.items():
        driver, method, seed, neighbours = name.split("/")
        key = (driver, _RENAMED.get(method, method), neighbours)
        by_seed.setdefault(key, {})[int(seed)] = [_number(entry[end]) for end in ("value", "low", "high")]
    return by_seed


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


def driver_rows(tests: Tests, draws: int, seed: int) -> Iterator[dict[str, Any]]:
    """Every figure, and how far it is from other rows' (`_compared`), `<metric>.minus_<row>`, by the seeds that both have.

    n is the number of scenes that are summed up: of the primary endpoint the rich ones, of red lights those that met some.
    """
    drawn = Draws(tests, draws, seed)
    for driver, method in tests.values:
        shared = tests.shared_seeds(driver, method)
        for neighbours, prefix in NEIGHBOURS.items():
            about: dict[str, Any] = {"data": tests.data, "protocol": tests.protocol, "driver": driver, "method": method}
            about |= {"neighbours": neighbours, "n": 0, "seeds": len(shared)}
            for metric in METRICS:
                if metric == "imposed_braking" and not prefix:
                    continue
                mine = tests.values[driver, method]
                about["n"] = int(np.count_nonzero(_sides(mine, shared, metric, prefix)[1].any(axis=0)))
                yield about | {"metric": metric} | as_columns(interval(_figure(mine, shared, metric, prefix, drawn)))
                for other in _compared(method, metric):
                    theirs = tests.values.get((driver, other), {})
                    if both := sorted(set(mine) & set(theirs)):
                        ours, others = (_figure(of, both, metric, prefix, drawn) for of in (mine, theirs))
                        less = as_columns(interval(ours - others))
                        yield about | {"metric": f"{metric}.minus_{other}", "seeds": len(both)} | less
            if not prefix:
                yield from _by_seed(tests, driver, method, about)
            diversity = tests.diversity[driver, method, neighbours]
            of_seeds = [Interval(*diversity[one]) for one in shared if one in diversity]
            about["n"] = len(tests.recordings)
            yield about | {"metric": "div"} | as_columns(envelope(of_seeds))


def _by_seed(tests: Tests, driver: str, method: str, about: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The primary endpoint among replayed neighbours, by each policy seed of a row."""
    for one, columns in sorted(tests.values[driver, method].items()):
        above, below = _sides({one: columns}, [one], PRIMARY, NEIGHBOURS["replayed"])
        if below.any():  # some scene is rich
            value = {"value": float(above.sum() / below.sum()), "low": None, "high": None}
            yield {**about, "metric": f"{BY_SEED}{one}", **value, "seeds": 1, "n": int(columns["rich"].sum())}


def _compared(method: str, metric: str) -> list[str]:
    """The rows from which a row's distance is published."""
    own = {CASES: [OURS, SHOWN], SHOWN: [OURS]}.get(method, [LOGS] if method.startswith(AMOUNT) else [])
    return [*([REFERENCE] if method != REFERENCE else []), *(own if metric == PRIMARY else [])]


def _figure(of_seeds: Mapping[int, Columns], seeds: Sequence[int], metric: str, prefix: str, drawn: Draws) -> NDArray[np.float64]:
    """(1 + D,) the metric of a row's policies of some `seeds`, first as it is."""
    policies = drawn.policies(seeds)
    sides = _sides(of_seeds, seeds, metric, prefix)
    above, below = ((policies * (drawn.scenes @ side.T)).sum(axis=1) for side in sides)
    figure: NDArray[np.float64] = np.abs(np.divide(above, below, out=np.full(len(below), np.nan), where=below != 0))
    return figure


def _sides(
    of_seeds: Mapping[int, Columns], seeds: Sequence[int], metric: str, prefix: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What is summed above and below, (seeds, S) each, 0 where one of both is not known."""
    names = (name if name in (ONE, *_SHARED) else f"{prefix}{name}" for name in METRICS[metric])
    above, below = (np.stack([of_seeds[one][name] for one in seeds]) for name in names)
    finite = np.isfinite(above) & np.isfinite(below)
    return np.where(finite, above, 0.0), np.where(finite, below, 0.0)
