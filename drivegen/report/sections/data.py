"""The data: what was read, accepted and rejected, what kinds of scenes they are, and the limits they calibrated."""

from collections.abc import Mapping
from typing import Any

from drivegen.report import plots
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import matrix, tables, words
from drivegen.report.table import Table, number, row

_QUANTITIES = {
    "speed": "speed [m/s]",
    "acceleration": "acceleration [m/s2]",
    "headway": "headway [s]",
    "lateral_offset": "lateral offset [m]",
    "lane_changes": "lane changes [1/km]",
    "standing": "share that stands",
    "time_to_collision": "time to collision [s]",
}


def section(evidence: Evidence) -> Section:
    """Counts of the ingest stage, and labels of the test scenarios."""
    ingest = evidence.results.get("ingest")
    lead = "Every recording is accepted or rejected with a reason, and counted."
    if evidence.source:
        lead += f" Source: {evidence.source}."
    figures = _labels(evidence)
    parts = (*_counts(ingest), *tables("assets", "Vehicle assets", evidence.results.get("assets")))
    return Section("data", "Data", lead, parts, figures, missing="" if ingest else not_measured("ingest"))


def likeness(evidence: Evidence) -> Section:
    """How near the corpus' traffic is to that of people."""
    measured = evidence.results.get("likeness")
    lead = (
        "What learns from simulated logs is judged on people. Seven distances say how far the simulated traffic is from theirs."
    )
    if not isinstance(measured, Mapping):
        return Section("likeness", "Simulated and real traffic", lead, missing=not_measured("likeness"))
    if "distance" not in measured:
        missing = f"Not measured: likeness.root names no folder with recordings of {', '.join(measured['without'])}."
        return Section("likeness", "Simulated and real traffic", lead, missing=missing)
    return Section("likeness", "Simulated and real traffic", lead, (_distances(measured),))


def _distances(figures: Mapping[str, Any]) -> Table:
    unit, distance = figures["unit"], figures["distance"]
    columns = ("", "halves of real driving", *(f"{'real driving' if name == 'all' else name} [halves]" for name in distance))
    rows = [
        row(
            text,
            number(unit[name], 3),
            *(number(apart[name] / unit[name] if unit[name] else float("nan"), 2) for apart in distance.values()),
            origin="ours",
        )
        for name, text in _QUANTITIES.items()
    ]
    notes = (
        f"{figures['scenes']} training scenes of the SUMO corpus (simulated) beside recordings of people, as distances in units "
        "of how far halves of the recordings are apart: 1 is as different as one half of real driving is from the other. "
        "Real driving: all data sets, each counted equally.",
        "Wasserstein-1 distances in the unit of the first column; lane changes and the standing share are differences. Motor "
        "vehicles on a lane, tracks averaged over 0.4 s on both sides; lateral offsets less the recording's median.",
    )
    return Table("likeness", "Distance of simulated to real traffic", columns, tuple(rows), notes)


def limits(evidence: Evidence) -> Section:
    """The legal checker's limits and how many logged tracks pass them."""
    measured = evidence.results.get("calibrate")
    share = f"{100 * measured['share']:g} %" if measured else "a stated share"
    lead = f"Limits of the legal checker are set so that {share} of logged tracks pass each of them."
    missing = "" if measured else not_measured("calibrate")
    return Section("limits", "Legal checker", lead, _by_rule(measured), missing=missing)


def _by_rule(limits: Any) -> tuple[Table, ...]:
    """`{"limits": {rule: x}, "pass_rate": {rule: y}, ...}` with one row a rule; what has no limit is a verdict or "legal"."""
    if not isinstance(limits, Mapping):
        return ()
    groups = {
        name: limits[name] for name in ("limits", *sorted(set(limits) - {"limits"})) if isinstance(limits.get(name), Mapping)
    }
    limited = groups.get("limits", {})
    names = list(dict.fromkeys(name for values in groups.values() for name in values))
    rows = {name: {group: values[name] for group, values in groups.items() if name in values} for name in names}
    rules = {name: row for name, row in rows.items() if name in limited}
    verdicts = {name.lower(): row for name, row in rows.items() if name not in limited}
    rest = {name: value for name, value in limits.items() if name not in groups}
    named = [matrix("checker", "Limits and pass rates", rules, "rule")] if rules else []
    named += [matrix("checker-verdicts", "Pass rates by verdict", verdicts, "verdict")] if verdicts else []
    return (*named, *tables("checker-settings", "Calibration", rest))


def _counts(ingest: Any) -> tuple[Table, ...]:
    """Counts by split and data set as one table, and whatever else the stage says."""
    if not isinstance(ingest, Mapping) or not isinstance(ingest.get("splits"), Mapping):
        return tables("data", "Scenarios", ingest)
    splits = [(split, ingest["splits"][split]) for split in ("train", "val", "test") if split in ingest["splits"]]
    rows = {f"{split}, {source}": counts for split, sources in splits for source, counts in sources.items()}
    rest = {key: value for key, value in ingest.items() if key != "splits" and value}
    return (matrix("scenarios", "Scenarios by split", rows, "split"), *tables("data", "Training data", rest))


def _labels(evidence: Evidence) -> tuple[Figure, ...]:
    quality = evidence.below("quality_details")
    values = quality.get("log") or next(iter(quality.values()), None)
    if not values:
        return ()
    figures = []
    for aspect in ("road", "conflict", "density"):
        prefix = f"label.{aspect}."
        counts = {words(key.removeprefix(prefix)): float(v) for key, v in sorted(values.items()) if key.startswith(prefix)}
        if counts:
            figures.append(Figure.svg(f"Test scenes by {aspect}", "", plots.bars(counts, "scenes")))
    moves = {words(key.removeprefix("manoeuvre.")): float(v) for key, v in sorted(values.items()) if key.startswith("manoeuvre.")}
    if moves:
        figures.append(Figure.svg("Vehicles by manoeuvre", "All vehicles of the test scenes.", plots.bars(moves, "vehicles")))
    return tuple(figures)
