"""Generators to compare with: how large they are, what they learnt from, how long it took, and whether the loss is flat."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivegen.report import plots
from drivegen.report.evidence import Curve, Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import Cell, Row, Table, measured, number, row, taken

_FLAT = 0.05
"""A curve is called flat if its last quarter gained no more than this share of all that was gained."""

FLAT_NOTE = f"Flat: the last quarter of the steps gained at most {_FLAT:.0%} of all that was gained."

_SCORES = ("min_sade", "min_sfde", "mean_sade", "mean_sfde")
_BOUND = ".validation_min_sade"
"""Ends the name of a figure of a bound, which begins with the bound's own name."""

_NOTES = (
    "Trained on the same logs as DriveGen; the weights of the lowest validation loss are kept, TrafficGen's of the lowest error "
    "when rolled out on some validation scenes. Errors [m] are those of the validation scenes, on which every choice was made, "
    "not of the test scenes. Losses of different generators don't compare.",
    FLAT_NOTE,
)


def section(evidence: Evidence) -> Section:
    """All trained generators side by side, and their curves."""
    trained = {name: value for name, value in evidence.below("train_generator").items() if isinstance(value, Mapping)}
    title = "Generators to compare with"
    lead = "Other ways to generate traffic, as their papers describe them; what is reduced to train here is said in each file."
    if not trained:
        return Section("generators", title, lead, missing=not_measured("train_generator"))
    curves = {curve.title.removeprefix("train_generator/"): curve for curve in evidence.curves}
    rows: list[Row] = []
    for name, values in trained.items():
        rows.append(_line(evidence.title(name), values, curves.get(name)))
        bounds = [key.removesuffix(_BOUND) for key in values if key.endswith(_BOUND)]
        rows += [_bound(f"{evidence.title(bound)} (a bound, no method)", values, bound) for bound in bounds]
    columns = (
        "generator", "parameters", "train examples", "steps", "validation loss", "flat",
        *(key.replace("_s", "-s").replace("sade", "sADE").replace("sfde", "sFDE") for key in _SCORES),
    )  # fmt: skip
    table = Table("generators", title, columns, tuple(rows), (*_NOTES, *evidence.trained_on))
    times = {evidence.title(name): evidence.costs.get(f"train_generator/{name}", {}) for name in trained}
    drawn = {evidence.title(name): curves[name] for name in trained if name in curves}
    return Section("generators", title, lead, (table, _times(times)), _figures(drawn))


def _line(title: str, values: Mapping[str, Any], curve: Curve | None) -> Row:
    counts = (number(values.get(key)) for key in ("parameters", "train_examples", "steps"))
    loss = measured(dict(values), "validation_loss", 3)
    settled = "–" if curve is None else flat(curve.columns.get("validation", ()))
    scores = (measured(dict(values), f"validation_{key}", 2) for key in _SCORES)
    return row(title, *counts, loss, settled, *scores)


def _bound(text: str, values: Mapping[str, Any], key: str) -> Row:
    scores = (measured(dict(values), f"{key}.validation_{score}", 2) for score in _SCORES)
    return row(text, *[Cell("–")] * 5, *scores)


def _times(times: Mapping[str, Mapping[str, float]]) -> Table:
    """What training took on this machine."""
    rows = [row(title, taken(took, "training_cpu_seconds")) for title, took in times.items()]
    note = "Training alone, without reading logs and without scoring."
    return Table("generators-times", "Training of generators", ("generator", "CPU-s"), tuple(rows), (note,), repeatable=False)


def flat(losses: Sequence[float]) -> str:
    """Whether the best loss of the first three quarters is near the best of all; nothing for fewer than four rows."""
    seen = [loss for loss in losses if loss == loss]
    if len(seen) < 4:
        return "–"
    before, best = min(seen[: len(seen) * 3 // 4]), min(seen)
    return "yes" if before - best <= _FLAT * max(seen[0] - best, 0.0) else "not yet"


def _figures(curves: Mapping[str, Curve]) -> tuple[Figure, ...]:
    return tuple(
        Figure.svg(f"Training: {title}", "", plots.curves(curve.columns, "step"))
        for title, curve in curves.items()
        if len(curve.columns.get("step", ())) > 1
    )
