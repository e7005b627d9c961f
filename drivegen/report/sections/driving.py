"""Drivers: replayed logs, downstream training (table II) and what corner cases cost (table IV)."""

from drivegen.report import paper
from drivegen.report.evidence import Evidence
from drivegen.report.section import Section, not_measured
from drivegen.report.sections._generic import tables
from drivegen.report.table import NOT_MEASURED, Table, row

COLUMNS = ("CR", "Dis [m]", "Comfort", "Div")


def section(evidence: Evidence) -> Section:
    """Every driver that was driven, and the paper's downstream table."""
    drivers = evidence.below("driving")
    lead = (
        "The target is driven by a driver, the others replay. CR is the share of scenes in which the driver collides, Dis "
        "the distance driven, Comfort the reciprocal of its mean acceleration, Div the spread of its trajectories."
    )
    found = tuple(
        table
        for name, values in drivers.items()
        for table in tables(f"driving-{name.replace('/', '-')}", f"Driver {name}", values)
    )
    missing = "" if drivers else not_measured("drive")
    return Section("driving", "Driving", lead, (*found, _downstream()), missing=missing)


def _downstream() -> Table:
    heads = ("", "data", *(f"{driver} {column}" for driver in ("GAIL", "SAC") for column in COLUMNS))
    ours = [row(f"{name}, ours", NOT_MEASURED, *[NOT_MEASURED] * 8, origin="ours") for name in ("Dataset", "DriveGen")]
    theirs = [
        row(name, paper.MARK, *(paper.printed(value) for driver in drivers for value in driver), origin="paper")
        for name, drivers in paper.DOWNSTREAM.items()
    ]
    notes = ("Training drivers on generated scenarios is not part of this run.",)
    return Table("downstream", "Table II. Drivers trained on generated scenarios", heads, (*ours, *theirs), notes)
