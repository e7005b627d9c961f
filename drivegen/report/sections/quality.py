"""Scenario quality: the paper's table I, the readings of diversity, and how safe the generated traffic is."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from drivegen.report import paper, plots
from drivegen.report.averaged import taken_over
from drivegen.report.columns import EDGES, EDGES_MEAN, FLOOR, MARKS, mark
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import NOT_MEASURED, Cell, Table, measured, number, row

_COLUMNS = ("min_sade", "min_sfde", "mean_sade", "mean_sfde", "diversity_ratio")


def section(evidence: Evidence) -> Section:
    """Tables and plot of realism and diversity."""
    methods = evidence.ordered(evidence.below("quality_details"))
    lead = (
        f"{'Samples' if evidence.samples is None else f'{evidence.samples} samples'} of every test scenario from its map, its "
        "first frame, signals as they show then, against what was logged. "
        "Distances in metres, mean over scenarios with bootstrap intervals over recordings; every vehicle of every sample counts."
    )
    parts = (_realism(methods, evidence), *((_diversity(methods, evidence),) if methods else ()))
    figures = (_map_of_methods(methods, evidence),) if methods else ()
    return Section("quality", "Scenario quality", lead, parts, figures, missing="" if methods else not_measured("evaluate"))


def safety(evidence: Evidence) -> Section:
    """Collision and off-road rates of generated traffic, which the paper does not report."""
    methods = evidence.ordered(evidence.below("quality_details"))
    lead = (
        "What the legal checker finds in the same samples. Nobody is dropped here: where nothing legal was found, the least "
        "illegal sample stays and counts. The log's row is what perception noise and box sizes alone amount to."
    )
    if not methods:
        return Section("safety", "Safety of generated traffic", lead, missing=not_measured("evaluate"))
    rates = {"collision": "collision", "off_road": "off-road", "illegal": "any violation"}
    named = {f"{rate}_per_{of}": f"{word}, per {of}" for rate, word in rates.items() for of in ("vehicle", "scene")}
    lines = [
        row(
            name_of(method, methods, evidence),
            *(_share(values, name) for name in (*named, *EDGES)),
            origin=evidence.origin(method),
        )
        for method, values in methods.items()
    ]
    title = "Share of generated vehicles and scenes with a violation, and of those that drive out of the map"
    kinds = sorted({key for values in methods.values() for key in values if key.startswith("violation.")} - _bounds(methods))
    by_kind = [
        row(name_of(method, methods, evidence), *(_share(values, kind) for kind in kinds), origin=evidence.origin(method))
        for method, values in methods.items()
    ]
    heads = ("", *(kind.removeprefix("violation.").replace("_", " ") for kind in kinds))
    notes = (*evidence.trained_on, *taken_over(methods))
    parts = (
        Table("safety", title, ("", *named.values(), *EDGES.values()), tuple(lines), (*notes, EDGES_MEAN)),
        Table("violations", "Share of generated vehicles by violation", heads, tuple(by_kind), notes),
    )
    return Section("safety", "Safety of generated traffic", lead, parts)


def name_of(method: str, measured: Mapping[str, Mapping[str, Any]], evidence: Evidence) -> str:
    """The method in words, marked where constant velocity is no worse."""
    return evidence.title(method) + mark(method, evidence.methods.get(method), measured.get(method, {}), measured.get(FLOOR, {}))


def _realism(methods: Mapping[str, dict[str, Any]], evidence: Evidence) -> Table:
    best = {key: _best(methods, key, evidence) for key in _COLUMNS}
    ours = []
    for method, values in evidence.rows(methods).items():
        cells = [replace(measured(values, key), best=method == best[key]) for key in _COLUMNS]
        source = (evidence.source or NOT_MEASURED) if values else NOT_MEASURED
        ours.append(
            row(name_of(method, methods, evidence), source, _chosen_by(method, evidence), *cells, origin=evidence.origin(method))
        )
    theirs = [row(name, paper.MARK, "", *map(number, values), origin="paper") for name, values in paper.QUALITY.items()]
    errors = ("min-sADE \u2193", "min-sFDE \u2193", "mean-sADE \u2193", "mean-sFDE \u2193", "diversity \u2192 1")
    notes = (
        "Rows of different data cannot be compared with one another; the paper's are printed for orientation.",
        "Errors are taken at steps 1 to T-1 (step 0 is given), the final one at each track's last observed step.",
        *MARKS,
    )
    heads = ("", "data", "goals chosen by", *errors)
    return Table(
        "quality", "Table I. Scenario quality", heads, (*ours, *theirs), (*evidence.trained_on, *taken_over(methods), *notes)
    )


def _chosen_by(method: str, evidence: Evidence) -> str:
    """Who chose goals, in the selector's own words where the goals stage has written them down."""
    selector = evidence.methods[method].goals if method in evidence.methods else None
    if selector is None:
        return "\u2013"
    measured = evidence.results.get(f"goals/{selector}")
    return str(measured.get("described", selector)) if isinstance(measured, Mapping) else selector


def _best(methods: Mapping[str, dict[str, Any]], key: str, evidence: Evidence) -> str:
    """The best of those that generate, "" if there are fewer than two; those that are told the truth win nothing."""
    rivals = [method for method in methods if method in evidence.methods and evidence.methods[method].competes]
    values = {method: methods[method][key] for method in rivals if methods[method].get(key) is not None}
    badness = {method: abs(value - 1) if key == "diversity_ratio" else value for method, value in values.items()}
    return min(badness, key=badness.__getitem__) if len(badness) > 1 else ""


def _diversity(methods: Mapping[str, dict[str, Any]], evidence: Evidence) -> Table:
    readings = ("diversity_ratio", "diversity_ratio_plain", "diversity_ratio_any_sample", "diversity_ratio_any_sample_plain")
    heads = ("", "best sample, squared (paper)", "best sample, plain norm", "random sample, squared", "random sample, plain norm")
    lines = [
        row(name_of(method, methods, evidence), *(measured(values, key) for key in readings), origin=evidence.origin(method))
        for method, values in methods.items()
    ]
    pairs = number(next((values["diversity_pairs"] for values in methods.values() if "diversity_pairs" in values), None))
    notes = (
        f"Ratio to the real set on {pairs} seeded random pairs of scenes; the paper writes the squared norm. Steps that the log "
        "did not observe are left out of both.",
    )
    return Table(
        "diversity", "Readings of the diversity ratio", heads, tuple(lines), (*evidence.trained_on, *taken_over(methods), *notes)
    )


def _map_of_methods(methods: Mapping[str, dict[str, Any]], evidence: Evidence) -> Figure:
    """Without the log, which is perfect by definition, and what is so far off that nothing else could be told apart."""
    shown = {name: values for name, values in methods.items() if name not in evidence.methods or evidence.methods[name].competes}
    ours = {
        evidence.title(name): (float(values["diversity_ratio"]), float(values["min_sade"]))
        for name, values in shown.items()
        if values.get("diversity_ratio") is not None and values.get("min_sade") is not None
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
