"""How the primary endpoint of tuned drivers falls with the amount of generated traffic among their lessons."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drivegen.report import plots
from drivegen.report.published.drivers import HEADS, PRIMARY_WORDS, PROTOCOLS, Figures, by_test, primary, scenes
from drivegen.report.published.tuned import AMOUNT, LOGS, PRIMARY
from drivegen.report.table import Row, Table, estimate, row

NEIGHBOURS = "replayed"
COLUMNS = {
    PRIMARY: HEADS[PRIMARY],
    f"{PRIMARY}.minus_{LOGS}": "less without generated traffic",
    "counted": HEADS["counted"],
    "cr": HEADS["cr"],
}
"""Of each driver."""


def amount_tables(rows: Sequence[Mapping[str, Any]], about: Mapping[str, tuple[str, int]]) -> Iterator[Table]:
    """A table with its chart for each data set and protocol in which drivers were tuned on amounts; see `driver_tables`."""
    tests = {test: figures for test, figures in by_test(rows).items() if test[3] == NEIGHBOURS and len(_amounts(figures)) > 1}
    for data, protocol in dict.fromkeys(test[:2] for test in tests):
        drivers = {driver: figures for (of, by, driver, _), figures in tests.items() if (of, by) == (data, protocol)}
        title, recordings = about[data]
        figures = next(iter(drivers.values()))
        heads = [f"{name.upper()}: {head}" for name in drivers for head in COLUMNS.values()]
        notes = (
            f"{PRIMARY_WORDS} Tuned on the logs of the tuning scenes with so many of DriveGen's futures of each among them, for "
            f"as many steps in every row. {scenes(figures, next(iter(figures))[0])} of {recordings} recordings; 95 % intervals "
            "over recordings crossed with policy seeds, which are few, so they hold less; differences paired by both.",
            PROTOCOLS[protocol],
        )
        yield Table(
            f"drivers-{data}-{protocol}-amounts",
            f"Table II, by amount. Drivers tuned on logs and more and more generated traffic, neighbours {NEIGHBOURS}: {title}",
            ("generated, times the logs", *heads, "policy seeds"),
            tuple(_row(amount, drivers) for amount in _amounts(figures)), notes, picture=_picture(drivers),
        )  # fmt: skip


def _amounts(figures: Figures) -> list[int]:
    """Those that were measured, rising; 0 are the logs alone."""
    methods = {method for method, _ in figures}
    amounts = [int(method.removeprefix(AMOUNT)) for method in methods if method.startswith(AMOUNT)]
    return sorted([*amounts, *([0] if LOGS in methods else [])])


def _method(amount: int) -> str:
    return f"{AMOUNT}{amount}" if amount else LOGS


def _row(amount: int, drivers: Mapping[str, Figures]) -> Row:
    method = _method(amount)
    cells = [
        primary(figures, method) if metric == PRIMARY else estimate(figures.get((method, metric)))
        for figures in drivers.values()
        for metric in COLUMNS
    ]
    seeds = dict.fromkeys(str(figures[method, "cr"]["seeds"]) for figures in drivers.values() if (method, "cr") in figures)
    return row(str(amount), *cells, ", ".join(seeds))


def _picture(drivers: Mapping[str, Figures]) -> bytes:
    lines = {}
    for name, figures in drivers.items():
        bars = {str(amount): figures[_method(amount), PRIMARY] for amount in _amounts(figures)}
        ends = {amount: (each["value"], each["low"], each["high"]) for amount, each in bars.items()}
        lines[name.upper()] = {amount: three for amount, three in ends.items() if None not in three}
    return plots.steps(lines, "generated traffic, times the logs", HEADS[PRIMARY])
