"""Corner cases, published: rows of figures over several seeds."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drivegen.report.published.seeds import estimate_of

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

    Values and ends are means over seeds that have them (`estimate_of`). n is the number of scenes, from each of which
    one case is handed over: 1 000 of these take `cpu_seconds_per_1000`, as many counted runs `cpu_seconds_per_1000_counted`.
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
            found = estimate_of([[attacks[key].get(source + end) for end in ("", ".low", ".high")] for attacks, _ in runs])
            if found["seeds"]:
                neighbours = "reactive" if name == "survives_reaction" else "replayed"
                count = {"n": int(first["scenarios"]), "seeds": found.pop("seeds")}
                yield {**about, "neighbours": neighbours, "metric": name, **found, **count}
        taken = [(costs[key], attacks[key]["scenarios"]) for attacks, costs in runs if key in costs]
        seconds = sum(cost["cpu_seconds"] for cost, _ in taken)
        counts = {"cpu_seconds_per_1000": sum(scenes for _, scenes in taken)}
        counts["cpu_seconds_per_1000_counted"] = sum(cost["cases"] for cost, _ in taken)
        for name, count in counts.items():
            if count:
                price = {"metric": name, "value": 1000 * seconds / count, "low": None, "high": None, "n": int(count)}
                yield {**about, "neighbours": "replayed", **price, "seeds": len(taken)}
