"""Rates of failure in traffic that follows the natural law, published: rows over several seeds, one table."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drivegen.report.published.seeds import mean_of_all
from drivegen.report.table import Cell, Row, Table, number, row

NAME = "failure-rates"
METRICS = ("rate", "runs", "covered", "width", "bias", "plain", "covered_plain", "width_plain", "saves")
HOUR = 3600.0

Rates = Mapping[str, Any]
"""What the stage `rates` says of one run."""


def rate_rows(data: str, runs: Sequence[Rates]) -> Iterator[dict[str, Any]]:
    """Rows {data, driver, metric, value, low, high, n, seeds}, a run a seed; values are means over seeds.

    Low and high are of the rate alone, over recordings; n is the number of scenes of the first run. `saves` and `bias` are
    None where a driver never failed in one of them. `per_hour` is of driving in such scenes.
    """
    for driver in runs[0]["drivers"]:
        of_runs = [run["drivers"][driver] for run in runs]
        about = {"data": data, "driver": driver, "n": runs[0]["scenes"], "seeds": len(runs)}
        for metric in METRICS:
            ends = {
                end: mean_of_all([one[f"rate.{end}"] if metric == "rate" else None for one in of_runs]) for end in ("low", "high")
            }
            yield {**about, "metric": metric, "value": mean_of_all([one[metric] for one in of_runs]), **ends}
        hourly = [one["rate"] * HOUR / run["seconds"] for one, run in zip(of_runs, runs, strict=True)]
        yield {**about, "metric": "per_hour", "value": mean_of_all(hourly), "low": None, "high": None}


def rate_table(rates: Rates) -> Table:
    """All tested drivers of one run, whoever fails most first."""
    drivers = rates["drivers"]
    order = sorted(drivers, key=lambda name: (-drivers[name]["rate"], name))
    return Table(
        NAME,
        "How often a driver fails in law-abiding generated traffic, and what an interval from few runs is worth",
        (
            "driver",
            "scenes in a million that end in a counted collision",
            "per hour",
            "runs",
            "intervals that hold the rate",
            "off by",
            "their width, in a million",
            "plain runs",
            "their intervals that hold it",
            "their width",
            "plain runs that one of ours is worth",
        ),
        tuple(_line(name, drivers[name], rates["seconds"]) for name in order),
        _notes(rates),
    )


def _line(name: str, own: Mapping[str, Any], seconds: float) -> Row:
    ends = "" if own["rate.low"] is None else f"{_million(own['rate.low'])} to {_million(own['rate.high'])}"
    return row(
        name,
        Cell(_million(own["rate"]), ends),
        f"{own['rate'] * HOUR / seconds:.2g}",
        number(round(own["runs"])),
        f"{own['covered']:.1%}",
        "-" if own["bias"] is None else f"{own['bias']:+.1%}",
        _million(own["width"]),
        number(own["plain"]),
        f"{own['covered_plain']:.1%}",
        _million(own["width_plain"]),
        "-" if own["saves"] is None else f"{own['saves']:.1f}",
    )


def _million(share: float) -> str:
    return f"{share * 1e6:.0f}"


def _notes(rates: Rates) -> tuple[str, ...]:
    return (
        "The law: all vehicles but the target draw their goals by their own odds; whole scenes in which anybody is illegal are "
        "rejected, those in which goals exclude one another are nearly never drawn; who stayed illegal in the one future that "
        "says who is there is in no draw; neighbours react. "
        f"{number(rates['draws'])} draws in each of {rates['scenes']} scenes of {rates['recordings']} recordings; in "
        f"{rates['left_out']} more too few draws were legal. These draws stand for the law: the share of them that ends in a "
        "counted collision is the true rate, in brackets with 95 % over recordings.",
        f"Intervals are of {rates['repetitions']} repetitions, each with runs of its own. Ours run the driver once in each "
        "scene, sort all draws by how near the others' plans come to where it drove, and then run it more where it fails; plain "
        "ones are of draws as they come. Off by: the mean of our estimates, less the rate, as a share of it.",
        "Per hour: of driving in such scenes, of which logs say how often they occur, not we.",
    )
