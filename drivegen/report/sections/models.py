"""What was trained: the goal selector, with its curve."""

from drivegen.report import plots
from drivegen.report.evidence import Curve, Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import matrix, tables


def selector(evidence: Evidence) -> Section:
    """The learned ranker of goals."""
    found = evidence.results.get("train_selector")
    goals = {
        f"{name}, {vehicles} vehicles": scores
        for name, value in evidence.below("goals").items()
        if isinstance(value, dict)
        for vehicles, scores in value.items()
        if isinstance(scores, dict)
    }
    lead = "The learned selector ranks candidate goals as drivers in the logs chose them; it is no language model."
    compared = (matrix("selectors", "Selectors on test scenes", goals, "selector"),) if goals else ()
    parts = (*compared, *tables("selector", "Learned selector", found))
    missing = "" if found or goals else not_measured("train_selector")
    return Section("selector", "Goal selection", lead, parts, _curves(evidence, "train_selector"), missing=missing)


def _curves(evidence: Evidence, folder: str) -> tuple[Figure, ...]:
    mine = [curve for curve in evidence.curves if curve.title.startswith(folder) and len(curve.columns) > 1]
    return tuple(
        Figure.svg(f"Training: {_short(curve)}", "", plots.curves(curve.columns, next(iter(curve.columns)))) for curve in mine
    )


def _short(curve: Curve) -> str:
    return curve.title.removeprefix("train_").replace("/", " ").replace("_", " ")
