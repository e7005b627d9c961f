"""Generators to compare with: how large they are, what they learnt from, how long it took, and whether more would help."""

from collections.abc import Mapping
from typing import Any

from drivegen.report import plots
from drivegen.report.evidence import Curve, Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import Cell, Row, Table, measured, number, row, taken

PLATEAU_NOTE = (
    "Plateau: in the last third of the steps the least error of roll-outs on validation logs fell by less than 1 %. Where it "
    "says no, the training was stopped while it still gained; \u2013: too short to tell."
)

TEMPERATURE_NOTE = (
    "Temperature: of the odds that futures are drawn from, below 1 the likely gains. Of one list for all rivals it "
    "is the one at which min-sADE, mean-sADE and energy score of some validation scenes add up to least; \u2013: none was chosen."
)

_SCORES = ("min_sade", "min_sfde", "mean_sade", "mean_sfde")
_BOUND = ".validation_min_sade"
"""Ends the name of a figure of a bound, which begins with the bound's own name."""

_NOTES = (
    "Trained on the same logs as DriveGen; the weights of the lowest error when rolled out on some validation scenes are kept. "
    "Errors [m] are those of the validation scenes, on which every choice was made, not of the test scenes. Losses of different "
    "generators don't compare.",
    PLATEAU_NOTE,
    TEMPERATURE_NOTE,
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
        rows.append(_line(evidence.title(name), values))
        bounds = [key.removesuffix(_BOUND) for key in values if key.endswith(_BOUND)]
        rows += [_bound(f"{evidence.title(bound)} (a bound, no method)", values, bound) for bound in bounds]
    columns = (
        "generator", "parameters", "train examples", "steps", "validation loss", "plateau", "temperature",
        *(key.replace("_s", "-s").replace("sade", "sADE").replace("sfde", "sFDE") for key in _SCORES),
    )  # fmt: skip
    table = Table("generators", title, columns, tuple(rows), (*_NOTES, *evidence.trained_on))
    times = {evidence.title(name): evidence.costs.get(f"train_generator/{name}", {}) for name in trained}
    shown = {evidence.title(name): curves[name] for name in trained if name in curves}
    return Section("generators", title, lead, (table, _times(times)), _figures(shown))


def _line(title: str, values: Mapping[str, Any]) -> Row:
    counts = (number(values.get(key)) for key in ("parameters", "train_examples", "steps"))
    loss = measured(dict(values), "validation_loss", 3)
    scores = (measured(dict(values), f"validation_{key}", 2) for key in _SCORES)
    return row(title, *counts, loss, yes_no(values.get("plateau")), tempered(values.get("sampling_temperature")), *scores)


def _bound(text: str, values: Mapping[str, Any], key: str) -> Row:
    scores = (measured(dict(values), f"{key}.validation_{score}", 2) for score in _SCORES)
    return row(text, *[Cell("–")] * 6, *scores)


def _times(times: Mapping[str, Mapping[str, float]]) -> Table:
    """What training took on this machine."""
    rows = [row(title, taken(took, "training_cpu_seconds")) for title, took in times.items()]
    note = "Training alone, without reading logs and without scoring."
    return Table("generators-times", "Training of generators", ("generator", "CPU-s"), tuple(rows), (note,), repeatable=False)


def yes_no(plateau: bool | None) -> str:
    """What a model's `plateau` says, in a word."""
    return "–" if plateau is None else "yes" if plateau else "no"


def tempered(temperature: float | None) -> str:
    """The temperature that was chosen for a model, as a cell."""
    return "–" if temperature is None else f"{temperature:g}"


def _figures(curves: Mapping[str, Curve]) -> tuple[Figure, ...]:
    return tuple(
        Figure.svg(f"Training: {title}", "", plots.curves(curve.columns, "step"))
        for title, curve in curves.items()
        if len(curve.columns.get("step", ())) > 1
    )
