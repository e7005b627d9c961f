"""The paper's second table: drivers tuned on each method's scenes, tested on others; rows and tables out of stage `drive_tuned`.

Every figure is a ratio of sums over scenes, each the mean over policy seeds; intervals resample recordings, and all methods meet
the same draws, so differences are paired by scene.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.core.intervals import percentiles, recording, resamplings
from drivegen.core.seeds import rng
from drivegen.report import paper
from drivegen.report.table import Row, Table, estimate, row

PRIMARY = "counted_rich"
"""The primary endpoint, declared before anything was measured: counted collisions among replayed neighbours, on test scenes that
are rich in encounters by their logs."""

BY_SEED = f"{PRIMARY}.seed_"
"""What the same of one policy seed is called, before the seed."""

REFERENCE = "dataset_longer"
"""The row that others are compared with: the same steps, without generated traffic."""

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

METHODS = {
    "dataset": "Dataset",
    REFERENCE: "Dataset, for as long",
    "scene_transformer": "SceneTransformer",
    "bits": "BITS",
    "trafficgen": "TrafficGen",
    "lctgen": "LCTGen",
    "drivegen_without_maps": "DriveGen w/o maps",
    "drivegen_without_goals": "DriveGen w/o gs",
    "drivegen": "DriveGen",
    "true_goals": "true goals (a ceiling)",
    "log": "logs of the same scenes (a ceiling)",
}
"""Rows in their order."""

NEIGHBOURS = {"replayed": "", "reactive": "reactive."}
_SHARED = ("rich", "logged")

HEADS = {
    "cr": "CR",
    "dis": "Dis [m]",
    "comfort": "Comfort [s2/m]",
    "div": "Div [m]",
    "counted": "counted collisions",
    PRIMARY: "counted, in scenes rich in encounters",
    "progress": "way driven, of the logged",
    "red_lights": "red lights run, of those met",
    "off_road": "share of time off the road",
    "imposed_braking": "braking imposed on others [m/s2]",
    f"{PRIMARY}.minus_{REFERENCE}": "counted in rich scenes, less Dataset for as long",
}
"""Columns of the tables, the paper's four first."""

PRIMARY_WORDS = (
    "Primary endpoint, declared beforehand: counted collisions in scenes rich in encounters by their logs, neighbours replayed."
)
PROTOCOLS = {
    "clean": "Clean: tuned on futures of first frames on which no generator was trained; nobody learned where it is tested.",
    "paper": "The paper's: tuned on the futures, of ten the nearest to the log, of the very scenes that are tested on. One seed.",
    "": "",
}
_RENAMED = {"drivegen_true_goals": "true_goals"}

Columns = dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Tests:
    """Runs of all policies on one data set.

    Attributes:
        data, protocol: what stands in the rows. recordings: (S,) of the scenes. seeds: of each (driver, method).
        values: of each (driver, method) the columns (S,) by name, means over seeds.
        diversity: of each (driver, method, neighbours) Div with its interval, means over seeds.
        primary: of each (driver, method) the primary endpoint by policy seed, replayed neighbours; none where no scene is rich.
    """

    data: str
    protocol: str
    recordings: Sequence[str]
    seeds: Mapping[tuple[str, str], int]
    values: Mapping[tuple[str, str], Columns]
    diversity: Mapping[tuple[str, str, str], list[float]]
    primary: Mapping[tuple[str, str], dict[int, float]]


def read_tests(data: str, protocol: str, results: pa.Table, diversity: Mapping[str, Mapping[str, float | None]]) -> Tests:
    """From the rows of `drive_tuned` and its JSON of diversities, `<driver>/<method>/<seed>/<neighbours>`."""
    names = ("driver", "method", "metric", "scenario", "seed")
    driver, method, metric, scenario, seed = (np.asarray(results[name].to_pylist(), object) for name in names)
    value, ids = results["value"].to_numpy(), sorted(set(scenario.tolist()))
    place = {name: i for i, name in enumerate(ids)}
    values: dict[tuple[str, str], Columns] = {}
    seeds: dict[tuple[str, str], int] = {}
    primary: dict[tuple[str, str], dict[int, float]] = {}
    for key in dict.fromkeys(zip(driver.tolist(), method.tolist(), strict=True)):
        mine = (driver == key[0]) & (method == key[1])
        named = (key[0], _RENAMED.get(key[1], key[1]))
        seeds[named] = len(set(seed[mine].tolist()))
        columns: Columns = {ONE: np.ones(len(ids))}
        for name in dict.fromkeys(metric[mine].tolist()):
            chosen = mine & (metric == name)
            at = [place[one] for one in scenario[chosen]]
            total, count = np.bincount(at, value[chosen], len(ids)), np.bincount(at, minlength=len(ids))
            columns[name] = np.divide(total, count, out=np.full(len(ids), np.nan), where=count > 0)
        rich = mine & (metric == "counted") & np.isin(scenario, [name for name in ids if columns["rich"][place[name]]])
        primary[named] = {one: float(value[rich & (seed == one)].mean()) for one in sorted(set(seed[rich].tolist()))}
        for prefix in NEIGHBOURS.values():
            columns[f"{prefix}counted_rich"] = columns[f"{prefix}counted"] * columns["rich"]
        values[named] = columns
    return Tests(data, protocol, [recording(name) for name in ids], seeds, values, _diversities(diversity), primary)


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
    """Every figure, and for each method but the reference how far it is from that, `<metric>.minus_dataset_longer`."""
    resampled = resamplings(tests.recordings, draws, rng(seed, "drivers", tests.data))
    times = np.concatenate([np.ones((1, len(tests.recordings))), resampled])
    for (driver, method), columns in tests.values.items():
        for neighbours, prefix in NEIGHBOURS.items():
            about: dict[str, Any] = {"data": tests.data, "protocol": tests.protocol, "driver": driver, "method": method}
            about |= {"neighbours": neighbours, "n": len(tests.recordings), "seeds": tests.seeds[driver, method]}
            reference = tests.values.get((driver, REFERENCE))
            for metric in METRICS:
                if metric == "imposed_braking" and not prefix:
                    continue
                figure = _figure(columns, metric, prefix, times)
                yield about | {"metric": metric} | _interval(figure)
                if reference is not None and method != REFERENCE:
                    apart = figure - _figure(reference, metric, prefix, times)
                    yield about | {"metric": f"{metric}.minus_{REFERENCE}"} | _interval(apart)
            for one, value in ({} if prefix else tests.primary[driver, method]).items():
                yield about | {"metric": f"{BY_SEED}{one}", "value": value, "low": None, "high": None, "seeds": 1}
            numbers = zip(("value", "low", "high"), tests.diversity[driver, method, neighbours], strict=True)
            yield about | {"metric": "div"} | {name: number if np.isfinite(number) else None for name, number in numbers}


def _figure(columns: Columns, metric: str, prefix: str, times: NDArray[np.floating]) -> NDArray[np.float64]:
    """(1 + draws,) the metric, first as it is."""
    above, below = (columns[name if name in (ONE, *_SHARED) else f"{prefix}{name}"] for name in METRICS[metric])
    finite = np.isfinite(above) & np.isfinite(below)
    sums = times @ np.where(finite, above, 0.0), times @ np.where(finite, below, 0.0)
    figure: NDArray[np.float64] = np.abs(np.divide(*sums, out=np.full(len(times), np.nan), where=sums[1] != 0))
    return figure


def _interval(figure: NDArray[np.float64]) -> dict[str, float | None]:
    low, high = percentiles(figure[1:][np.isfinite(figure[1:])])
    numbers = {"value": float(figure[0]), "low": low, "high": high}
    return {name: number if np.isfinite(number) else None for name, number in numbers.items()}


def driver_tables(rows: Sequence[Mapping[str, Any]], about: Mapping[str, tuple[str, int]]) -> Iterator[Table]:
    """A table for each data set, protocol, driver and kind of neighbours; `about` each data set its title and recordings."""
    kinds = dict.fromkeys((each["data"], each["protocol"], each["driver"], each["neighbours"]) for each in rows)
    for data, protocol, driver, neighbours in kinds:
        mine = {
            (each["method"], each["metric"]): each
            for each in rows
            if (each["data"], each["protocol"], each["driver"], each["neighbours"]) == (data, protocol, driver, neighbours)
        }
        there = [method for method in METHODS if (method, "cr") in mine]
        shown = [metric for metric in HEADS if any((method, metric) in mine for method in there)]
        lines = [_row(method, shown, mine) for method in there]
        if neighbours == "replayed":
            lines += _theirs(driver, len(shown))
        title, recordings = about[data]
        first = mine[there[0], "cr"]
        notes = (
            f"{PRIMARY_WORDS} {first['n']} scenes of {recordings} recordings, policy seeds: {first['seeds']}; 95 % intervals "
            "over recordings for the policies as they are, the last column paired by scene; the primary endpoint also by policy "
            "seed. Comfort is the reciprocal of the mean absolute acceleration.",
            PROTOCOLS[protocol],
        )
        yield Table(
            f"drivers-{data}-{protocol}-{driver}-{neighbours}",
            f"Table II, extended. {driver.upper()} tuned on each method's scenes, neighbours {neighbours}: {title}",
            ("tuned on", *(HEADS[metric] for metric in shown)), tuple(lines), notes,
        )  # fmt: skip


def _row(method: str, shown: Sequence[str], figures: Mapping[tuple[str, str], Mapping[str, Any]]) -> Row:
    cells = {metric: estimate(figures.get((method, metric))) for metric in shown}
    seeds = [f"{each['value']:.3f}" for (who, metric), each in figures.items() if who == method and metric.startswith(BY_SEED)]
    if len(seeds) > 1:
        cells[PRIMARY] = replace(cells[PRIMARY], note=f"{cells[PRIMARY].note}; seeds {', '.join(seeds)}")
    return row(METHODS[method], *cells.values(), origin="ours" if method.startswith("drivegen") else "rival")


def _theirs(driver: str, columns: int) -> list[Row]:
    """What the paper prints, in its first four columns."""
    number = {"gail": 0, "sac": 1}.get(driver)
    if number is None:
        return []
    return [
        row(f"{name} ({paper.MARK})", *printed[number], *[""] * (columns - 4), origin="paper")
        for name, printed in paper.DOWNSTREAM.items()
    ]
