"""Vehicles from words and from data: what was asked against what was got, its price, and first frames beside those of logs."""

from collections.abc import Mapping
from typing import Any

from drivegen.report import plots
from drivegen.report.averaged import over_recordings
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import Cell, Row, Table, measured, number, row

_HEADS = ("asked for", "read by", "times", "got", "by chance", "natural", "illegal", "illegal unasked", "least time gap [s]")
_NOTES = (
    "got: share of what was asked for that is seen in the scene. by chance: share that came about in the same first frame when "
    "nobody asked for it. natural: median probability that the learned selector itself gives to the goals that the words demand.",
    "illegal: share of vehicles that broke a rule or were left out because nothing legal was found, under the words and with the "
    "selector's own goals. The suite and the rules that read it were written by the same hand.",
)

_MEASURES = {
    "speed": "speed [m/s]",
    "gap": "gap to the leader [m]",
    "heading": "heading [deg]",
    "offset": "from the lane's middle [m]",
}


def section(evidence: Evidence) -> Section:
    """The suite of requests, and the distribution of headways."""
    of_words, place = evidence.results.get("asked"), evidence.results.get("place")
    headways = place.get("headways") if isinstance(place, Mapping) else None
    tables = [_kinds(of_words)] if isinstance(of_words, Mapping) else []
    lead = (
        "Words say how many vehicles there are, of which kinds, how dense, how fast, where they stand and what single ones do. "
        "Manoeuvres bind the goal of one vehicle; the planner and the checker stay as they are."
    )
    figures: list[Figure] = []
    if isinstance(headways, Mapping):
        figures, tables = _headways(headways), [*tables, _headway_table(headways)]
    started = evidence.results.get("initial_states")
    if isinstance(started, Mapping):
        tables = [*tables, _first_frames(started)]
    missing = "" if tables else not_measured("asked")
    return Section("vehicles", "Vehicles from words", lead, tuple(tables), tuple(figures), missing=missing)


def _kinds(measured: Mapping[str, Any]) -> Table:
    reader = str(measured.get("reader", ""))
    rows = [_kind(name, reader, values) for name, values in measured["kinds"].items() if name != "misread"]
    read = f"{measured['read_as_meant']} of {measured['scenes']} readings of {measured['requests']} requests were as meant; "
    placed = f"{measured['vehicles_placed']} of {measured['vehicles_asked']} vehicles were placed."
    return Table("asked", "Traffic in words", _HEADS, tuple(rows), (read + placed, *_NOTES))


def _kind(name: str, reader: str, values: Mapping[str, Any]) -> Any:
    return row(
        name.replace("_", " "),
        reader,
        number(values["asked"]),
        *(_or_dash(values[key], 2) for key in ("got", "by_chance", "natural", "illegal", "illegal_free", "least_time_gap")),
        origin="ours",
    )


def _or_dash(value: float | None, digits: int) -> Cell:
    return Cell("–" if value is None else number(float(value), digits))


def _headways(headways: Mapping[str, Any]) -> list[Figure]:
    series = {name: values["time_gap"] for name, values in headways.items() if values.get("time_gap")}
    if not series:
        return []
    picture = plots.shares(series, "time gap to the leader [s]")
    return [Figure.svg("Headways at the first frame", "Placed by each mode, and in held-out logs (cumulative share).", picture)]


def _headway_table(headways: Mapping[str, Any]) -> Table:
    heads = ("", "vehicles", "with a leader", "median gap [m]", "median time gap [s]", "distance to held-out logs [s]")
    rows = [
        row(
            name,
            number(values["vehicles"]),
            number(values["led"]),
            number(values["gap_median"]),
            number(values["time_gap_median"]),
            _or_dash(values.get("distance"), 2),
            origin="ours",
        )
        for name, values in headways.items()
    ]
    note = "distance: Wasserstein-1 distance between the time gaps of moving vehicles with a leader, up to 10 s."
    return Table("headways", "Headways of placed vehicles and of held-out logs", heads, tuple(rows), (note,))


def _first_frames(started: Mapping[str, Any]) -> Table:
    heads = ("", "placed", *_MEASURES.values(), "overlapping", "on no lane")
    rows = [_first_frame(one["name"], one) for one in started["methods"]]
    notes = (
        f"As many vehicles as the log has, on the maps of {started['scenes']} test scenes. Speed to the lane's middle: "
        "Wasserstein-1 distances to the logs', of all vehicles but the target; heading is against the lane's. "
        f"{over_recordings(started['recordings'])} The last two are shares of vehicles. All methods draw anew where vehicles "
        "would overlap.",
        "All are given the log's target, but in the two rows that say otherwise; in mode paper DriveGen takes nothing but sizes "
        "from logs. The bound's code says roughly where every logged vehicle stands and how fast it is.",
    )
    return Table("first_frames", "First frames on the maps of held-out logs", heads, tuple(rows), notes)


def _first_frame(text: str, values: Mapping[str, Any]) -> Row:
    distances = [measured(dict(values), name, 2) if name in values else Cell("–") for name in _MEASURES]
    shares = [_share(values, name) for name in ("overlap", "off_lane")]
    return row(text, f"{values['placed']} of {values['asked']}", *distances, *shares, origin="ours")


def _share(values: Mapping[str, Any], name: str) -> Cell:
    value, low, high = (values[f"{name}{end}"] for end in ("", ".low", ".high"))
    if value is None:
        return Cell("–")
    return Cell(f"{100 * value:.1f} %", "" if low is None else f"{100 * low:.1f}\u2013{100 * high:.1f}")
