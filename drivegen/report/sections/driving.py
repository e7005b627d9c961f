"""Drivers: how they drive in logged and in generated traffic."""

from collections.abc import Mapping, Sequence
from math import nan
from typing import Any

from drivegen.core.scenario import DT
from drivegen.metrics.driving import NEIGHBOURS
from drivegen.report import plots
from drivegen.report.averaged import over_recordings
from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure, Section, not_measured
from drivegen.report.table import Table, measured, number, row

PAPER_COLUMNS = {"CR": "collision", "Dis [m]": "distance", "Comfort": "comfort_absolute", "Div": "spread_over_runs"}
"""The paper's columns -> names in a driver's or a round's JSON, in the readings that we compare with."""

_COLUMNS = {
    "CR": "collision",
    "of it at fault": "collision.at_fault",
    "by nuPlan's classes": "collision.nuplan_at_fault",
    "artefacts": "collision.artefact",
    "imposed braking [m/s2]": "imposed_braking",
    "red lights run": "red_share",
    "in the first second": "collision.in_first_second",
    "off-road": "off_road",
    "Dis [m]": "distance",
    "of what was planned": "progress",
    "Comfort, absolute": "comfort_absolute",
    "Comfort, signed": "comfort_signed",
    "Div over scenes": "spread_over_runs",
    "Div over samples": "spread_over_samples",
}


ENOUGH = 6000
"""Who was taught in fewer scenes is called under-trained: of so many GAIL runs hardly a red light, of 600 one in ten."""


def section(evidence: Evidence) -> Section:
    """Every driver that was driven, by traffic."""
    drivers = {name: by_traffic(values) for name, values in evidence.below("driving").items() if isinstance(values, Mapping)}
    lead = (
        "The target is driven by a driver; its neighbours are replayed, or react to it by braking. CR is the share of runs that "
        "end in a collision, Dis the way "
        "driven, Comfort the reciprocal of the mean acceleration, Div the spread of trajectories; where the paper can be read "
        "in two ways, both are here."
    )
    parts = [_table(name, traffic, evidence) for name, traffic in drivers.items()]
    missing = "" if drivers else not_measured("drive")
    return Section("driving", "Driving", lead, tuple(parts), _speeds(evidence.results.get("recordings", ())), missing=missing)


def _speeds(recordings: Sequence[Mapping[str, Any]]) -> tuple[Figure, ...]:
    """Of all drivers in the same scenes."""
    driven = [one for one in recordings if "speed" in one]
    if not driven:
        return ()
    names = sorted(driven[0]["speed"], key=lambda name: (name != "logged", name))
    scenes = {one["scenario"]: {name: _over_time(one["speed"][name]) for name in names} for one in driven}
    ends = "; ".join(f"{name} in {one['scenario']}" for one in driven for name in one["collided"])
    caption = (
        "The target's speed in scenes drawn by seed, as logged and as each driver drives it along the same path among replayed "
        f"neighbours. A line ends where the log does, at the map's end or with a collision ({ends or 'none here'}). "
        "Each scene has a recording."
    )
    return (
        Figure.svg("The same scenes by every driver", caption, plots.panels(scenes, "s", "m/s", 3, (plots.LOG, *plots.SERIES))),
    )


def _over_time(speed: Sequence[float | None]) -> tuple[list[float], list[float]]:
    """Times and speeds; NaN, which breaks the line, where nobody saw it."""
    return [step * DT for step in range(len(speed))], [nan if value is None else value for value in speed]


def by_traffic(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Flat names `<traffic>.<metric>` as one mapping per traffic."""
    out: dict[str, dict[str, Any]] = {}
    for key, value in values.items():
        traffic, _, metric = key.partition(".")
        out.setdefault(traffic, {})[metric] = value
    return out


def _table(driver: str, traffic: Mapping[str, dict[str, Any]], evidence: Evidence) -> Table:
    lines = []
    for name, values in evidence.ordered(traffic).items():
        for kind, prefix in NEIGHBOURS.items():
            if f"{prefix}collision" in values:
                cells = [measured(values, prefix + key) for key in _COLUMNS.values()]
                lines.append(
                    row(evidence.title(name), kind, number(values.get(f"{prefix}runs")), *cells, origin=evidence.origin(name))
                )
    over = tuple({over_recordings(int(values["recordings"])): None for values in traffic.values() if "recordings" in values})
    notes = (*_teaching(evidence.results.get(f"train_driver/{driver}")), *evidence.trained_on, *over)
    return Table(f"driving-{driver}", f"Driver {driver}", ("traffic", "neighbours", "runs", *_COLUMNS), tuple(lines), notes)


def _teaching(taught: Any) -> tuple[str, ...]:
    """Of a driver that was taught: by how much, and how well that went."""
    if not isinstance(taught, Mapping):
        return ()
    share, scenes = 100 * float(taught["validation_collision"]), taught["train_scenes"]
    undertrained = ", so under-trained" if scenes < ENOUGH else ""
    return (
        f"Taught in {number(scenes)} logged scenes{undertrained}: the weights of round {number(taught['validation_round'])} "
        f"collide in {share:.1f} % of {number(taught['validation_scenes'])} validation scenes, among replayed neighbours.",
    )
