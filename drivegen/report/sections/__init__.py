"""All sections in the order of the page."""

from drivegen.report.evidence import Evidence
from drivegen.report.section import Section
from drivegen.report.sections import (
    about,
    attack,
    corner,
    data,
    driving,
    generators,
    maps,
    models,
    planners,
    quality,
    trust,
    vehicles,
)

_ORDER = (
    about.summary,
    about.scenes,
    about.comparisons,
    quality.section,
    quality.safety,
    trust.section,
    driving.section,
    corner.section,
    attack.section,
    data.section,
    data.likeness,
    data.limits,
    models.selector,
    planners.section,
    generators.section,
    maps.section,
    vehicles.section,
    about.recordings,
    about.provenance,
)


def all_sections(evidence: Evidence) -> list[Section]:
    """Every section; those without evidence say so."""
    return [section(evidence) for section in _ORDER]
