"""The page's frame: the numbers in brief, pictures of scenes, recordings, provenance."""

from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import Table, measured, row


def summary(evidence: Evidence) -> Section:
    """Three numbers of each method that was evaluated."""
    methods = evidence.ordered(evidence.below("quality_details"))
    lead = "DriveGen makes traffic scenarios from words, maps and logs, and corner cases for a given driver without training."
    if evidence.source:
        lead += f" All our numbers below are on: {evidence.source}."
    if not methods:
        return Section("summary", "In brief", lead, missing=not_measured("evaluate"))
    keys = ("min_sade", "diversity_ratio", "collision_per_vehicle")
    lines = [
        row(
            evidence.title(name),
            *(measured(values, key, 3 if "collision" in key else 2) for key in keys),
            origin=evidence.origin(name),
        )
        for name, values in methods.items()
    ]
    heads = ("", "min-sADE [m]", "diversity ratio", "vehicles in collision")
    return Section("summary", "In brief", lead, (Table("summary", "This run", heads, tuple(lines), evidence.trained_on),))


def scenes(evidence: Evidence) -> Section:
    """Pictures of test scenes."""
    lead = (
        "Test scenes drawn by seed, not chosen. Orange: the target; blue: the others; boxes stand at the first frame. Lines are "
        "all samples over one another, red where the checker objects; black dashes are the log, longer when faster. Thin pale "
        "dashes are what was planned, turned down by the checker and replaced, in all samples; a trajectory that broke several "
        "rules is counted for each. Who made way was legal, and was taken back because another vehicle found no way past it."
    )
    figures = tuple(Figure.png(picture, wide=True) for picture in evidence.scenes)
    return Section("scenes", "Scenes", lead, (), figures, missing="" if figures else not_measured("rollout"))


def comparisons(evidence: Evidence) -> Section:
    """The same scenes by every method."""
    lead = (
        "The same scenes by every method, in one window each. Lines are all samples over one another, red where the checker "
        "objects; black dashes are the log; diamonds are the goals that DriveGen's samples follow. Only DriveGen and its "
        "ablations plan again: thin pale dashes are what they planned, the checker turned down, and another trajectory replaced. "
        "The other methods plan once; what the checker would reject of theirs stays, and is red."
    )
    figures = tuple(Figure.png(picture, wide=True) for picture in evidence.comparisons)
    return Section("methods", "Methods side by side", lead, (), figures, missing="" if figures else not_measured("rollout"))


def recordings(evidence: Evidence) -> Section:
    """Links to recordings."""
    lead = "Open with `.venv/bin/drivegen view FILE`; the layout is saved inside."
    missing = "" if evidence.recordings else not_measured("record")
    return Section("recordings", "Recordings", lead, links=evidence.recordings, missing=missing)


def provenance(evidence: Evidence) -> Section:
    """Hashes and seeds."""
    lead = "Same seed, parameters and inputs give the same bytes on one machine and pin set; this page among them."
    lines = tuple(row(name, value) for name, value in evidence.provenance.items())
    tables = (Table("provenance", "Made from", ("", "value"), lines),) if lines else ()
    return Section("provenance", "Provenance", lead, tables)
