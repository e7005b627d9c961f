"""Corner cases: rounds against a given driver, beside the paper's tables III and IV."""

from collections.abc import Mapping
from itertools import chain
from typing import Any

from drivegen.report import paper, plots
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import matrix, tables
from drivegen.report.sections.driving import PAPER_COLUMNS, by_traffic
from drivegen.report.table import NOT_MEASURED, Row, Table, measured, row

DRIVERS = ("idm", "gail", "sac")
"""The drivers of table III."""


def section(evidence: Evidence) -> Section:
    """Rounds, what was learned, and the paper's tables."""
    rounds = {name: value for name, value in evidence.below("corner").items() if isinstance(value, Mapping)}
    lead = (
        "Rounds of generation steered by what made the driver fail. Nothing is trained: goals of social vehicles are drawn "
        "with other odds. The driver's own reaction is left out of the legality check; hard rules between social vehicles stay."
    )
    found = [_against_paper(evidence, rounds), _gpu_hours()]
    figures = []
    if rounds:
        found.append(matrix("corner-rounds", "Corner-case rounds", rounds, "round"))
        for name, values in rounds.items():
            nested = {key: value for key, value in values.items() if isinstance(value, Mapping | list)}
            found += tables(f"corner-{name}", f"Round {name}", nested)
        figures = _plot(rounds)
    missing = "" if rounds else not_measured("corner")
    return Section("corner", "Corner cases", lead, tuple(found), tuple(figures), missing=missing)


def _against_paper(evidence: Evidence, rounds: Mapping[str, Mapping[str, Any]]) -> Table:
    driving = {name: by_traffic(values) for name, values in evidence.below("driving").items() if isinstance(values, Mapping)}
    logs = {driver: traffic.get("log", {}) for driver, traffic in driving.items()}
    last = {"idm": dict(rounds[max(rounds)])} if rounds else {}
    source = evidence.source or NOT_MEASURED
    ours = [_our_row("Dataset, ours", source, logs), _our_row("DriveGen-CS, ours", source, last)]
    theirs = [row(name, paper.MARK, *chain(*drivers), origin="paper") for name, drivers in paper.CORNER.items()]
    heads = ("", "data", *(f"{driver.upper()} {column}" for driver in DRIVERS for column in PAPER_COLUMNS))
    notes = ("A high collision rate and low other columns are good for corner cases: they are hard for the driver.",)
    return Table("corner-cases", "Table III. Corner cases", heads, (*ours, *theirs), (*evidence.trained_on, *notes))


def _our_row(label: str, source: str, drivers: Mapping[str, dict[str, Any]]) -> Row:
    cells = [measured(drivers.get(driver, {}), key) for driver in DRIVERS for key in PAPER_COLUMNS.values()]
    return row(label, source, *cells, origin="ours")


def _gpu_hours() -> Table:
    ours = row("DriveGen-CS, ours", NOT_MEASURED, NOT_MEASURED, origin="ours")
    theirs = [row(name, *values, origin="paper") for name, values in paper.GPU_HOURS.items()]
    notes = ("Our times differ from run to run and are kept in reports/drivegen.duckdb, view cost_per_item.",)
    heads = ("", "finetune [GPU h]", "generate [GPU h]")
    return Table("gpu-hours", "Table IV. GPU hours for 1000 corner cases", heads, (ours, *theirs), notes)


def _plot(rounds: Mapping[str, Mapping[str, Any]]) -> list[Figure]:
    rates = {f"round {name}": values for name, values in rounds.items() if isinstance(values.get("collision"), float)}
    if not rates:
        return []
    groups = {name: float(values["collision"]) for name, values in rates.items()}
    ends = {
        name: (values["collision.low"], values["collision.high"]) for name, values in rates.items() if "collision.low" in values
    }
    return [Figure.svg("Collision rate by round", "With 95 % intervals.", plots.bars(groups, "collision rate", ends))]
