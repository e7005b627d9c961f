"""What was trained: the goal selector, with its curve."""

from collections.abc import Mapping
from typing import Any

from drivegen.report import plots
from drivegen.report.averaged import vehicles_over
from drivegen.report.evidence import Curve, Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import tables
from drivegen.report.table import NOT_MEASURED, Cell, Table, measured, number, row

SCORES = {
    "coverage_2m": "within 2 m",
    "coverage_4m": "within 4 m",
    "oracle_fde": "oracle FDE [m]",
    "hit_1": "hit@1",
    "hit_3": "hit@3",
    "hit_3_within_4m": "hit@3 within 4 m",
    "mean_reciprocal_rank": "MRR",
    "nll": "NLL [nat]",
    "calibration_error": "ECE",
    "expected_fde": "expected FDE [m]",
    "manoeuvre_accuracy": "manoeuvre",
    "entropy": "entropy [nat]",
}
"""Columns of that table."""

NOTES = (
    "Vehicles that move more than 2 m and are seen to the end.",
    "Within 2 and 4 m, oracle FDE: how near the nearest candidate is to the logged end, whoever chooses; the log adds its own, "
    "and a vision-language model is offered places to stop besides.",
    "Hit@k and MRR: rank of that candidate. Hit@3 within 4 m: one of the three likeliest is that near. Equal ones rank by lot.",
    "ECE: calibration error of the likeliest candidate's probability. Manoeuvre: share whose likeliest manoeuvre is that one.",
    "Label bias: how far along its numbers a model's first choice lies on average, less a half; beside it the scatter of chance.",
)


def selector(evidence: Evidence) -> Section:
    """Who ranks goals how well, and the learned ranker."""
    measured = evidence.results.get("train_selector")
    goals = {name: value for name, value in evidence.below("goals").items() if isinstance(value, dict)}
    lead = "A selector gives every vehicle's candidate goals odds. The learned one ranks them as drivers in the logs chose them."
    compared = (_selectors(goals, evidence.selectors),) if goals else ()
    parts = (*compared, *tables("selector", "Learned selector", measured))
    missing = "" if measured or goals else not_measured("train_selector")
    return Section("selector", "Goal selection", lead, parts, _curves(evidence, "train_selector"), missing=missing)


def _selectors(goals: dict[str, dict[str, Any]], selectors: tuple[str, ...]) -> Table:
    """One row a selector, on the same candidates of the same moving vehicles; what was not run says so."""
    names = [*selectors, *sorted(set(goals) - set(selectors))]
    rows = []
    for name in names:
        values = goals.get(name, {})
        moving = values.get("moving", {})
        cells = [measured(moving, key) for key in SCORES]
        count = number(int(moving["vehicles"])) if "vehicles" in moving else NOT_MEASURED
        rows.append(row(name, _chosen_by(values), count, *cells, _label_bias(values)))
    columns = ("selector", "chosen by", "vehicles", *SCORES.values(), "label bias")
    return Table("selectors", "Selectors on test scenes", columns, tuple(rows), (*NOTES, *_over(goals)))


def _over(goals: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """What figures are of: the same vehicles for all selectors."""
    return next((vehicles_over(groups["moving"]) for groups in goals.values() if "moving" in groups), ())


def _chosen_by(values: dict[str, Any]) -> str:
    """Who chose, and for how many vehicles the fallback did."""
    asking = values.get("asking", {})
    stood_in = sum(asking.get("fallback", {}).values())
    words = str(values.get("described", NOT_MEASURED))
    return f"{words}; learned selector for {stood_in} of {asking['vehicles']} without an answer" if stood_in else words


def _label_bias(values: dict[str, Any]) -> Cell:
    """Of a model that sees numbers; the others see none."""
    asking = values.get("asking", {})
    if "label_bias" in asking:
        return Cell(f"{asking['label_bias']:+.2f}", f"\u00b1{asking['label_bias_by_chance']:.2f} by chance")
    return Cell("sees no numbers" if values and not asking else NOT_MEASURED)


def _curves(evidence: Evidence, folder: str) -> tuple[Figure, ...]:
    mine = [curve for curve in evidence.curves if curve.title.startswith(folder) and len(curve.columns) > 1]
    return tuple(
        Figure.svg(f"Training: {_short(curve)}", "", plots.curves(curve.columns, next(iter(curve.columns)))) for curve in mine
    )


def _short(curve: Curve) -> str:
    return curve.title.removeprefix("train_").replace("/", " ").replace("_", " ")
