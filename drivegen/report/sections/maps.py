"""Maps from words: how often they are what was asked for, how much they differ, checks and pictures."""

from collections.abc import Mapping
from typing import Any

from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.sections._generic import tables, words
from drivegen.report.table import NOT_MEASURED, Cell, Row, Table, measured, number, row

_LEAD = (
    "Roads made from descriptions: text, typed specification (or a language model's SUMO XML, read as data), SUMO network, road "
    "map. A description is right when the network loads in SUMO and has the structure that was asked for, or when one that can "
    "be no road is refused. Held-out descriptions were written without having read the rules."
)
_STEPS = {
    "roads": "roads asked for",
    "understood": "understood",
    "valid_xml": "valid XML",
    "accepted": "netconvert accepts",
    "loads": "loads in SUMO",
    "as_asked": "structure as asked",
    "repaired_after_1": "repaired after 1 round",
    "repaired_after_2": "after 2",
    "repaired_after_3": "after 3",
    "declined": "declined",
    "to_refuse": "no road at all",
    "refused": "refused rightly",
    "share_right": "share right",
}
_FEATURES = {
    "lanes": "most lanes per direction",
    "arms": "roads at the largest junction",
    "curvature": "degrees turned per 100 m",
    "length": "kilometres of lane",
    "connectivity": "ways on per lane",
}


def section(evidence: Evidence) -> Section:
    """The tables of the suite, of diversity and of the maps stage, with a picture of each map."""
    found, suite = evidence.results.get("maps"), evidence.results.get("map_suite")
    parts = [*_suite(suite), *_diversity(evidence.results.get("map_diversity")), *tables("maps", "Maps", found)]
    parts += tables("shipped", "New scenarios", evidence.results.get("ship"))
    figures = tuple(Figure.png(picture, wide=False) for picture in evidence.maps)
    missing = "" if found or suite or figures else not_measured("maps")
    return Section("maps", "Maps from words", _LEAD, tuple(parts), figures, missing=missing)


def _suite(found: Any) -> list[Table]:
    """By writer and suite, and by kind for every writer that was measured."""
    if not isinstance(found, Mapping) or not found.get("writers"):
        return []
    writers = sorted(found["writers"].values(), key=lambda writer: not writer["measured"])
    rows = [line for writer in writers for line in _writer(writer)]
    notes = tuple(_first(one) for one in found.get("first_try", ()))
    told = [Table("map-suite", "Maps from words: how often right", ("written by", "suite", *_STEPS.values()), tuple(rows), notes)]
    for writer in writers:
        if writer["measured"]:
            title = f"Maps from words by kind: {writer['written_by']}"
            rows = [row(words(kind), *_counts(counts)) for kind, counts in writer["kinds"].items()]
            told.append(Table(f"map-suite-{_slug(writer['written_by'])}", title, ("kind", *_STEPS.values()), tuple(rows)))
    return told


def _writer(writer: Mapping[str, Any]) -> list[Row]:
    if not writer["measured"]:
        return [row(writer["written_by"], "", *[NOT_MEASURED] * len(_STEPS))]
    return [row(writer["written_by"], suite, *_counts(counts)) for suite, counts in writer["suites"].items()]


def _counts(counts: Mapping[str, Any]) -> list[Cell]:
    return [Cell(number(counts[step], 3)) for step in _STEPS]


def _first(one: Mapping[str, Any]) -> str:
    return (
        f"Held out, part {one['part']}, first try on {one['date']} (revision {one['revision']}): {one['as_asked']} of "
        f"{one['roads']} roads as asked, {one['declined']} declined; {one['refused']} of {one['to_refuse']} rightly refused."
    )


def _diversity(found: Any) -> list[Table]:
    if not isinstance(found, Mapping):
        return []
    columns = ("", "maps", "windows", *(name for title in _FEATURES.values() for name in (title, "spread")))
    rows = []
    for source, values in sorted(found["sources"].items(), reverse=True):
        if values is None:
            rows.append(row(source, *[NOT_MEASURED] * (len(columns) - 1)))
            continue
        cells = [c for name in _FEATURES for c in (measured(values, name), Cell(number(values[f"{name} spread"])))]
        rows.append(row(source, number(int(values["maps"])), number(int(values["windows"])), *cells))
    note = f"Windows of {number(found['radius'])} m radius; means with the middle 80 %, spread is the standard deviation."
    return [Table("map-diversity", "Maps from words beside real ones", columns, tuple(rows), (note,))]


def _slug(name: str) -> str:
    return "-".join("".join(c if c.isalnum() else " " for c in name.lower()).split())
