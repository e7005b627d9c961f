"""Maps from words: how often they are what was asked for, how much they differ, checks and pictures."""

from collections.abc import Mapping
from typing import Any

from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import tables
from drivegen.report.table import NOT_MEASURED, Cell, Row, Table, measured, number, row

_LEAD = (
    "Roads made from descriptions: text, typed specification (or a language model's SUMO XML, read as data), SUMO network, road "
    "map. A description is right when the network loads in SUMO and has what its author listed beforehand, or when one of which "
    "nothing can be drawn is declined. The fresh lines were written without having seen the phrase table."
)
_COUNTS = {
    "lines": "lines",
    "right": "right at once",
    "right_after_offer": "right after the offered sentence",
    "declined": "declined",
    "wrong": "wrong",
}
_FEATURES = {
    "lanes": "most lanes per direction",
    "arms": "roads at the largest junction",
    "curvature": "degrees turned per 100 m",
    "length": "kilometres of lane",
    "connectivity": "ways on per lane",
}


def section(evidence: Evidence) -> Section:
    """What became of the maps stage and of the scenarios on its maps, with a picture of each map."""
    built = evidence.results.get("maps")
    parts = [*tables("maps", "Maps", built), *tables("shipped", "New scenarios", evidence.results.get("ship"))]
    figures = tuple(Figure.png(picture, wide=False) for picture in evidence.maps)
    missing = "" if built or figures else not_measured("maps")
    return Section("maps", "Maps from words", _LEAD, tuple(parts), figures, missing=missing)


def suites(evidence: Evidence) -> Section:
    """How often maps from words are right, and how much they differ: `make tables PART=maps`."""
    parts = [*_suite(evidence.results.get("map_suite")), *_diversity(evidence.results.get("map_diversity"))]
    return Section("map-suites", "Maps from words, measured", _LEAD, tuple(parts))


def _suite(measured: Any) -> list[Table]:
    """By writer, suite and group."""
    if not isinstance(measured, Mapping) or not measured.get("writers"):
        return []
    writers = sorted(measured["writers"].values(), key=lambda writer: not writer["measured"])
    rows = [line for writer in writers for line in _writer(writer)]
    return [Table("map-suite", "Words: how often right", ("written by", "lines of", *_COUNTS.values()), tuple(rows))]


def _writer(writer: Mapping[str, Any]) -> list[Row]:
    if not writer["measured"]:
        return [row(writer["written_by"], "", *[NOT_MEASURED] * len(_COUNTS))]
    cells = {name: [Cell(number(counts[count], 3)) for count in _COUNTS] for name, counts in writer["groups"].items()}
    return [row(writer["written_by"], name, *values) for name, values in cells.items()]


def _diversity(table: Any) -> list[Table]:
    if not isinstance(table, Mapping):
        return []
    columns = ("", "maps", "windows", *(name for title in _FEATURES.values() for name in (title, "spread")))
    rows = []
    for source, values in sorted(table["sources"].items(), reverse=True):
        if values is None:
            rows.append(row(source, *[NOT_MEASURED] * (len(columns) - 1)))
            continue
        cells = [c for name in _FEATURES for c in (measured(values, name), Cell(number(values[f"{name} spread"])))]
        rows.append(row(source, number(int(values["maps"])), number(int(values["windows"])), *cells))
    note = f"Windows of {number(table['radius'])} m radius; means with the middle 80 %, spread is the standard deviation."
    return [Table("map-diversity", "Maps from words beside real ones", columns, tuple(rows), (note,))]
