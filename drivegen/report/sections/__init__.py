"""All sections in the order of the page."""

from drivegen.report.evidence import Evidence
from drivegen.report.section import Section
from drivegen.report.sections import about, corner, data, driving, maps, models, quality
from drivegen.report.table import Table

_ORDER = (
    about.summary,
    quality.section,
    quality.safety,
    about.scenes,
    driving.section,
    corner.section,
    data.section,
    data.limits,
    models.selector,
    models.planner,
    maps.section,
    about.recordings,
    about.provenance,
)


def all_sections(evidence: Evidence) -> list[Section]:
    """Every section; those without evidence say so."""
    return [section(evidence) for section in _ORDER]


def all_tables(evidence: Evidence) -> list[Table]:
    """Every table of every section."""
    return [table for section in all_sections(evidence) for table in section.tables]
