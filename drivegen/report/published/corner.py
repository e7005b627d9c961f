"""Corner cases for the published tables: rows of figures over several seeds, and the tables of the first one's."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

METRICS = {
    "cr": "collision",
    "dis": "distance",
    "comfort": "comfort_absolute",
    "div": "spread_over_runs",
    "counted": "counted",
    "avoidable": "avoidable",
    "legal_share": "legal_share",
    "kinds": "kinds",
    "survives_reaction": "survives_reaction",
    "odds": "odds",
}
"""Published name -> that of the stage's JSON."""

Attacks = Mapping[str, dict[str, Any]]
"""What one driver's attacks came to, by adversary, what is allowed and runs."""

Costs = Mapping[str, Mapping[str, float]]
"""What each attack took, by the same key."""


def corner_rows(data: str, driver: str, runs: Sequence[tuple[Attacks, Costs]]) -> Iterator[dict[str, Any]]:
    """Rows {data, driver, method, neighbours, allowed, queries, metric, value, low, high, n, seeds} of one driver, a run a seed.

    Values and ends are means over seeds; ends are NaN where none were measured. n is the number of scenes, from each of which one
    case is handed over: 1 000 of these take `cpu_seconds_per_1000`, as many counted runs `cpu_seconds_per_1000_counted`.
    """
    for key, first in runs[0][0].items():
        about = {
            "data": data,
            "driver": driver,
            "method": first["method"],
            "allowed": first["allowed"],
            "queries": first["budget"],
        }
        for name, source in METRICS.items():
            three = [[attacks[key].get(source + end) for attacks, _ in runs] for end in ("", ".low", ".high")]
            value, low, high = map(_mean, three)
            if value is not None:
                neighbours = "reactive" if name == "survives_reaction" else "replayed"
                ends = {"low": low, "high": high, "n": int(first["scenarios"]), "seeds": len(runs)}
                yield {**about, "neighbours": neighbours, "metric": name, "value": value, **ends}
        taken = [(costs[key], attacks[key]["scenarios"]) for attacks, costs in runs if key in costs]
        seconds = sum(cost["cpu_seconds"] for cost, _ in taken)
        counts = {"cpu_seconds_per_1000": sum(scenes for _, scenes in taken)}
        counts["cpu_seconds_per_1000_counted"] = sum(cost["cases"] for cost, _ in taken)
        for name, count in counts.items():
            if count:
                price = {"metric": name, "value": 1000 * seconds / count, "low": None, "high": None, "n": int(count)}
                yield {**about, "neighbours": "replayed", **price, "seeds": len(runs)}


def over_seeds(data: str, runs: Sequence[Sequence[Mapping[str, Any]]]) -> Iterator[dict[str, Any]]:
    """The rows of the first run with `data` and `seeds`; value and ends are means over runs that have them, else None.

    Rows are the same if all else that they hold agrees; `n` is the first run's.
    """
    alike = [{_about(line): line for line in run} for run in runs]
    for line in runs[0]:
        same = [run[_about(line)] for run in alike if _about(line) in run]
        means = {name: _mean([one[name] for one in same]) for name in ("value", "low", "high")}
        yield {"data": data, **line, **means, "seeds": len(same)}


def _about(line: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple((name, value) for name, value in line.items() if name not in ("value", "low", "high", "n"))


def _mean(values: Sequence[Any]) -> float | None:
    finite = [float(value) for value in values if value is not None and np.isfinite(value)]
    return float(np.mean(finite)) if finite else None


def mean_of_all(values: Sequence[float | bool | None]) -> float | None:
    """The mean over runs, None where one of them has none."""
    numbers = [float(value) for value in values if value is not None]
    return sum(numbers) / len(numbers) if len(numbers) == len(values) else None
