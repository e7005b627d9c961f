"""Maps from words: counts, checks and pictures."""

from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import tables


def section(evidence: Evidence) -> Section:
    """The table of the maps stage with a picture each, and the new scenarios on them."""
    found = evidence.results.get("maps")
    lead = "Roads made from descriptions: text, typed specification, SUMO network, road map. Written by offline rules."
    parts = (*tables("maps", "Maps", found), *tables("shipped", "New scenarios", evidence.results.get("ship")))
    figures = tuple(Figure.png(picture, wide=False) for picture in evidence.maps)
    return Section("maps", "Maps from words", lead, parts, figures, missing="" if found or figures else not_measured("maps"))
