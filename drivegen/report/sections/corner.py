"""Corner cases: rounds against a given driver, beside the paper's tables III and IV."""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

from drivegen.report import paper, plots
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import matrix, words
from drivegen.report.sections.driving import PAPER_COLUMNS, by_traffic
from drivegen.report.table import NOT_MEASURED, RESTORED, Cell, Row, Table, measured, number, row

_PAPER_DRIVERS = ("idm", "gail", "sac")
"""The drivers of the paper's table III, in its order."""


def section(evidence: Evidence) -> Section:
    """Rounds, what was learned, and the paper's tables."""
    found = evidence.below("corner")
    rounds = {name: found[name] for name in sorted(found, key=int) if isinstance(found[name], Mapping)}
    lead = (
        "Rounds of generation steered by what made the driver fail. Nothing is trained: goals of social vehicles are drawn "
        "with other odds. Neighbours are replayed. "
        "The driver's own reaction is left out of the legality check; hard rules between social vehicles stay."
    )
    parts = [_against_paper(evidence, rounds), _gpu_hours(rounds, evidence.costs)]
    figures = []
    if rounds:
        parts.append(matrix("corner-rounds", "Corner-case rounds", rounds, "round"))
        parts += [_knowledge(name, values["knowledge"]) for name, values in rounds.items() if values.get("knowledge")]
        figures = [*(Figure.png(picture, wide=False) for picture in evidence.collisions), *_plot(rounds)]
    missing = "" if rounds else not_measured("corner")
    return Section("corner", "Corner cases", lead, tuple(parts), tuple(figures), missing=missing)


def _against_paper(evidence: Evidence, rounds: Mapping[str, Mapping[str, Any]]) -> Table:
    driving = {name: by_traffic(values) for name, values in evidence.below("driving").items() if isinstance(values, Mapping)}
    logs = {driver: traffic.get("log", {}) for driver, traffic in driving.items()}
    newest = dict(rounds[max(rounds, key=int)]) if rounds else {}
    last = {str(newest.get("driver", "idm")): newest} if newest else {}
    source = evidence.source or NOT_MEASURED
    shown = [driver for driver in _PAPER_DRIVERS if logs.get(driver) or last.get(driver)]
    ours = [_our_row("Dataset, ours", source, logs, shown), _our_row("DriveGen-CS, ours", source, last, shown)] if shown else []
    places = [_PAPER_DRIVERS.index(driver) for driver in shown or _PAPER_DRIVERS]
    theirs = [
        row(name, paper.MARK, *chain(*(drivers[place] for place in places)), origin="paper")
        for name, drivers in paper.CORNER.items()
    ]
    heads = ("", "data", *(f"{_PAPER_DRIVERS[place].upper()} {column}" for place in places for column in PAPER_COLUMNS))
    notes = ("A high collision rate and low other columns are good for corner cases: they are hard for the driver.",)
    return Table("corner-cases", "Table III. Corner cases", heads, (*ours, *theirs), (*evidence.trained_on, *notes))


def _our_row(label: str, source: str, values: Mapping[str, dict[str, Any]], drivers: Sequence[str]) -> Row:
    cells = [measured(values.get(driver, {}), key) for driver in drivers for key in PAPER_COLUMNS.values()]
    return row(label, source, *cells, origin="ours")


def _knowledge(name: str, cells: Sequence[dict[str, Any]]) -> Table:
    heads = ("", "of the encounter", "encounters", "collisions", "P(collision)")
    lines = [
        row(words(cell["feature"]), words(cell["value"]), number(cell["encounters"]), number(cell["collisions"]), _odds(cell))
        for cell in cells
    ]
    notes = ("Shares of encounters that ended in a collision, with 95 % intervals, likeliest first; the next round uses them.",)
    return Table(f"corner-{name}-knowledge", f"Round {name}: what made the driver fail", heads, tuple(lines), notes)


def _odds(cell: dict[str, Any]) -> Cell:
    return measured({"p": cell["probability"], "p.low": cell["low"], "p.high": cell["high"]}, "p", 3)


def _gpu_hours(rounds: Mapping[str, Any], costs: Mapping[str, Mapping[str, float]]) -> Table:
    """Times differ from run to run: this table stands in the page only."""
    took = costs.get(f"corner/{max(rounds, key=int)}", {}) if rounds else {}
    hours = number(1000 * took["cpu_seconds"] / took["runs"] / 3600) if took.get("runs") else RESTORED
    on_gpu = any(name.endswith("gpu_seconds") for cost in costs.values() for name in cost)
    ours = [row("DriveGen-CS, ours", "0", NOT_MEASURED if on_gpu else "none", hours, origin="ours")] if rounds else []
    theirs = [row(name, *values, "\u2013", origin="paper") for name, values in paper.GPU_HOURS.items()]
    heads = ("", "finetune [GPU h]", "generate [GPU h]", "generate [CPU h]")
    note = "Ours: the last round, per 1000 scenarios that it made and drove, whether the driver failed in them or not."
    return Table("gpu-hours", "Table IV. Hours for 1000 corner cases", heads, (*ours, *theirs), (note,), repeatable=False)


def _plot(rounds: Mapping[str, Mapping[str, Any]]) -> list[Figure]:
    rates = {f"round {name}": values for name, values in rounds.items() if isinstance(values.get("collision"), float)}
    if not rates:
        return []
    groups = {name: float(values["collision"]) for name, values in rates.items()}
    ends = {
        name: (values["collision.low"], values["collision.high"])
        for name, values in rates.items()
        if values.get("collision.low") is not None
    }
    return [Figure.svg("Collision rate by round", "With 95 % intervals.", plots.bars(groups, "collision rate", ends))]
