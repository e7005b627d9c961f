"""The data: what was read, accepted and rejected, what kinds of scenes they are, and the limits they calibrated."""

from drivegen.report import plots
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import tables, words


def section(evidence: Evidence) -> Section:
    """Counts of the ingest stage, and labels of the test scenarios."""
    ingest = evidence.results.get("ingest")
    lead = "Every recording is accepted or rejected with a reason, and counted."
    if evidence.source:
        lead += f" Source: {evidence.source}."
    figures = _labels(evidence)
    found = (*tables("data", "Scenarios", ingest), *tables("assets", "Vehicle assets", evidence.results.get("assets")))
    return Section("data", "Data", lead, found, figures, missing="" if ingest else not_measured("ingest"))


def limits(evidence: Evidence) -> Section:
    """The legal checker's limits and how many logged tracks pass them."""
    found = evidence.results.get("calibrate")
    lead = "Limits of the legal checker are set so that 99 % of logged tracks pass each of them."
    missing = "" if found else not_measured("calibrate")
    return Section("limits", "Legal checker", lead, tables("checker", "Limits and pass rates", found), missing=missing)


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
