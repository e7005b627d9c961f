"""Scenario quality: the paper's table I, the readings of diversity, and how safe the generated traffic is."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from drivegen.report import paper, plots
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import NOT_MEASURED, Cell, Table, measured, number, row

NAMES = {
    "log": "Log (recorded futures)",
    "constant_velocity": "Constant velocity",
    "drivegen_without_goals": "DriveGen w/o gs",
    "drivegen": "DriveGen",
    "drivegen_true_goals": "DriveGen, true goals",
}
"""Methods in the table's order; others follow under their own names."""

_TOLD = ("log", "drivegen_true_goals")
"""Methods that are told what happened: bounds, not rivals."""

_COLUMNS = ("min_sade", "min_sfde", "mean_sade", "mean_sfde", "diversity_ratio")


def section(evidence: Evidence) -> Section:
    """Tables and plot of realism and diversity."""
    methods = ordered(evidence.below("quality_details"))
    lead = (
        "Ten samples of every test scenario from its map and first frame, against what was logged. Distances in metres, mean "
        "over scenarios with 95 % bootstrap intervals; every vehicle of every sample counts."
    )
    found = (_realism(methods, evidence), *((_diversity(methods, evidence),) if methods else ()))
    figures = (_map_of_methods(methods),) if methods else ()
    return Section("quality", "Scenario quality", lead, found, figures, missing="" if methods else not_measured("evaluate"))


def safety(evidence: Evidence) -> Section:
    """Collision and off-road rates of generated traffic, which the paper does not report."""
    methods = ordered(evidence.below("quality_details"))
    lead = (
        "What the legal checker finds in the same samples. Nobody is dropped here: where nothing legal was found, the least "
        "illegal sample stays and counts. The log's row is what perception noise and box sizes alone amount to."
    )
    if not methods:
        return Section("safety", "Safety of generated traffic", lead, missing=not_measured("evaluate"))
    rates = {"collision": "collision", "off_road": "off-road", "illegal": "any violation"}
    columns = ("", *(f"{word}, per {of}" for word in rates.values() for of in ("vehicle", "scene")))
    lines = [
        row(_name(method), *(_share(values, f"{rate}_per_{of}") for rate in rates for of in ("vehicle", "scene")))
        for method, values in methods.items()
    ]
    kinds = sorted({key for values in methods.values() for key in values if key.startswith("violation.")} - _bounds(methods))
    by_kind = [row(_name(method), *(_share(values, kind) for kind in kinds)) for method, values in methods.items()]
    heads = ("", *(kind.removeprefix("violation.").replace("_", " ") for kind in kinds))
    found = (
        Table("safety", "Share of generated vehicles and scenes with a violation", columns, tuple(lines), evidence.trained_on),
        Table("violations", "Share of generated vehicles by violation", heads, tuple(by_kind), evidence.trained_on),
    )
    return Section("safety", "Safety of generated traffic", lead, found)


def ordered(methods: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Known methods first, in the table's order."""
    known = [method for method in NAMES if method in methods]
    return {method: dict(methods[method]) for method in [*known, *sorted(set(methods) - set(NAMES))]}


def _realism(methods: Mapping[str, dict[str, Any]], evidence: Evidence) -> Table:
    best = {key: _best(methods, key) for key in _COLUMNS}
    ours = []
    for method in methods or NAMES:
        cells = [replace(measured(methods.get(method, {}), key), best=method == best[key]) for key in _COLUMNS]
        ours.append(row(_name(method), evidence.source or NOT_MEASURED, *cells, origin="ours"))
    theirs = [row(name, paper.MARK, *map(number, values), origin="paper") for name, values in paper.QUALITY.items()]
    heads = ("", "data", "min-sADE \u2193", "min-sFDE \u2193", "mean-sADE \u2193", "mean-sFDE \u2193", "diversity \u2192 1")
    notes = (
        "Rows of different data cannot be compared with one another; the paper's are printed for orientation.",
        "Errors are taken at steps 1 to T-1 (step 0 is given), the final one at each track's last observed step.",
    )
    return Table("quality", "Table I. Scenario quality", heads, (*ours, *theirs), (*evidence.trained_on, *notes))


def _best(methods: Mapping[str, dict[str, Any]], key: str) -> str:
    """The best of those that generate, "" if there are fewer than two; those that are told the truth win nothing."""
    values = {method: methods[method][key] for method in methods if method not in _TOLD and methods[method].get(key) is not None}
    badness = {method: abs(value - 1) if key == "diversity_ratio" else value for method, value in values.items()}
    return min(badness, key=badness.__getitem__) if len(badness) > 1 else ""


def _diversity(methods: Mapping[str, dict[str, Any]], evidence: Evidence) -> Table:
    readings = ("diversity_ratio", "diversity_ratio_plain", "diversity_ratio_any_sample", "diversity_ratio_any_sample_plain")
    heads = ("", "best sample, squared (paper)", "best sample, plain norm", "random sample, squared", "random sample, plain norm")
    lines = [
        row(_name(method), *(measured(values, key) for key in readings), origin="ours") for method, values in methods.items()
    ]
    pairs = number(next((values["diversity_pairs"] for values in methods.values() if "diversity_pairs" in values), None))
    notes = (
        f"Ratio to the real set on {pairs} seeded random pairs of scenes; the paper writes the squared norm. Steps that the log "
        "did not observe are left out of both.",
    )
    return Table("diversity", "Readings of the diversity ratio", heads, tuple(lines), (*evidence.trained_on, *notes))


def _map_of_methods(methods: Mapping[str, dict[str, Any]]) -> Figure:
    ours = {
        _name(method): (float(values["diversity_ratio"]), float(values["min_sade"]))
        for method, values in methods.items()
        if values.get("diversity_ratio") is not None and values.get("min_sade") is not None and method != "log"
    }
    theirs = {f"{name} (paper)": (values[4], values[0]) for name, values in paper.QUALITY.items()}
    caption = "Diamonds are ours on this run's data, circles the paper's on Argoverse 2. Low and near 1 is good."
    return Figure.svg("Realism against diversity", caption, plots.realism_against_diversity(ours, theirs))


def _bounds(methods: Mapping[str, dict[str, Any]]) -> set[str]:
    return {f"{key}{end}" for values in methods.values() for key in values for end in (".low", ".high")}


def _share(values: dict[str, Any], key: str) -> Cell:
    percent = {k: 100 * values[k] for k in (key, f"{key}.low", f"{key}.high") if values.get(k) is not None}
    cell = measured(percent, key, 1)
    return cell if cell.text == NOT_MEASURED else replace(cell, text=f"{cell.text} %")


def _name(method: str) -> str:
    return NAMES.get(method, method.replace("_", " "))
