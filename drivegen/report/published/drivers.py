"""The paper's second table: drivers tuned on each method's scenes, tested on others."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from drivegen.report import paper
from drivegen.report.published.figures import grouped
from drivegen.report.published.tuned import BY_SEED, CASES, LOGS, OURS, PRIMARY, REFERENCE, SHOWN
from drivegen.report.table import Cell, Row, Table, estimate, row

Figures = Mapping[tuple[str, str], Mapping[str, Any]]
"""Rows of `driver_rows` by (method, metric), of one data set, protocol, driver and kind of neighbours."""

METHODS = {
    "dataset": "Dataset",
    REFERENCE: "Dataset, for as long",
    "scene_transformer": "SceneTransformer",
    "bits": "BITS",
    "trafficgen": "TrafficGen",
    "lctgen": "LCTGen",
    "drivegen_without_maps": "DriveGen w/o maps",
    "drivegen_without_goals": "DriveGen w/o gs",
    OURS: "DriveGen",
    CASES: "DriveGen, a quarter corner cases",
    SHOWN: "DriveGen, a quarter shown by the careful driver",
    "true_goals": "true goals (a ceiling)",
    LOGS: "logs of the same scenes (a ceiling)",
}
"""Rows in their order."""

_OURS = {CASES, SHOWN, *(method for method in METHODS if method.startswith(OURS))}

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


def driver_tables(rows: Sequence[Mapping[str, Any]], about: Mapping[str, tuple[str, int]]) -> Iterator[Table]:
    """A table for each data set, protocol, driver and kind of neighbours; `about` each data set its title and recordings."""
    for (data, protocol, driver, neighbours), figures in by_test(rows).items():
        there = [method for method in METHODS if (method, "cr") in figures]
        shown = [metric for metric in HEADS if any((method, metric) in figures for method in there)]
        lines = [_row(method, shown, figures) for method in there]
        if neighbours == "replayed":
            lines += _theirs(driver, len(shown) + 1)
        title, recordings = about[data]
        notes = (
            f"{PRIMARY_WORDS} {scenes(figures, there[0])} of {recordings} recordings. Figures are means over the policy seeds "
            "that all rows have, differences over those that both rows have, paired by scene and seed; 95 % intervals over "
            "recordings crossed with policy seeds, of which three or five are few, so they hold less; of Div from the lowest end "
            "of a policy seed's interval over recordings to the highest. The primary endpoint also by each policy seed of a row. "
            "Comfort is the reciprocal of the mean absolute acceleration.",
            PROTOCOLS[protocol],
            *_with_cases(figures),
        )
        yield Table(
            f"drivers-{data}-{protocol}-{driver}-{neighbours}",
            f"Table II, extended. {driver.upper()} tuned on each method's scenes, neighbours {neighbours}: {title}",
            ("tuned on", *(HEADS[metric] for metric in shown), "policy seeds"), tuple(lines), notes,
        )  # fmt: skip


def scenes(figures: Figures, method: str) -> str:
    """How many scenes a row was tested in, and how many of these its primary endpoint is a share of."""
    return f"{figures[method, 'cr']['n']} scenes, {figures[method, PRIMARY]['n']} of them rich,"


def by_test(rows: Iterable[Mapping[str, Any]]) -> dict[tuple[str, str, str, str], Figures]:
    """Rows by (data set, protocol, driver, neighbours)."""
    return dict(grouped(rows, ("data", "protocol", "driver", "neighbours"), ("method", "metric")))


def primary(figures: Figures, method: str) -> Cell:
    """A row's primary endpoint with its interval, and by policy seed where there are several: rows differ in which they have."""
    cell = estimate(figures.get((method, PRIMARY)))
    mine = {metric: each for (who, metric), each in figures.items() if who == method and metric.startswith(BY_SEED)}
    of_seeds = {int(metric.removeprefix(BY_SEED)): each["value"] for metric, each in mine.items()}
    seeds = [f"{seed}: {value:.3f}" for seed, value in sorted(of_seeds.items())]
    return replace(cell, note="; ".join(filter(None, (cell.note, f"seeds {', '.join(seeds)}")))) if len(seeds) > 1 else cell


def _row(method: str, shown: Sequence[str], figures: Figures) -> Row:
    cells = [primary(figures, method) if metric == PRIMARY else estimate(figures.get((method, metric))) for metric in shown]
    seeds = str(figures[method, "cr"]["seeds"])
    return row(METHODS[method], *cells, seeds, origin="ours" if method in _OURS else "rival")


def _with_cases(figures: Figures) -> list[str]:
    """How far the row with corner cases is from the same scenes without them, as they are and as their teacher drives in them."""
    words = []
    for method, other in ((CASES, OURS), (CASES, SHOWN)):
        apart = estimate(figures.get((method, f"{PRIMARY}.minus_{other}")))
        ends = f" ({apart.note})" if apart.note else ""
        words += [f"Counted in rich scenes, {METHODS[method]} less {METHODS[other]}: {apart.text}{ends}."] if apart.text else []
    return words


def _theirs(driver: str, columns: int) -> list[Row]:
    """What the paper prints, in its first four columns."""
    number = {"gail": 0, "sac": 1}.get(driver)
    if number is None:
        return []
    return [
        row(f"{name} ({paper.MARK})", *printed[number], *[""] * (columns - 4), origin="paper")
        for name, printed in paper.DOWNSTREAM.items()
    ]
