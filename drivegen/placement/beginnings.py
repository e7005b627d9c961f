"""How vehicles stand at the first frame, and how far that is from how they stand in logs.

Of every vehicle but the target, which some are given: its speed, the gap to its leader, how far it is turned against the
lane under it and how far it is from the middle of that lane; and whether it overlaps anybody, or is on no lane. Numbers are
compared as in `metrics.distributions`: counts scene by scene, Wasserstein-1 distances of all, intervals over
recordings.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import boxes_overlap, wrap_angle
from drivegen.core.intervals import Interval, bootstrap_means, recording, resamplings
from drivegen.core.roadmap import NO_LANE
from drivegen.core.scenario import TARGET, Scenario, Vehicles
from drivegen.metrics.distributions import binned, distance
from drivegen.placement.gaps import gaps_of
from drivegen.roads.graph import LaneGraph
from drivegen.roads.parked import parked

RANGES = {"speed": (0.0, 48.0), "gap": (0.0, 120.0), "heading": (0.0, 90.0), "offset": (0.0, 6.0)}
"""Ends of the bins [m/s], [m], [deg], [m]; headings and offsets without their sign."""

RATES = ("overlap", "off_lane")
"""Shares of the vehicles."""

OFF_LANE = 1.0
"""[m] beyond the edge of every lane at which a vehicle's middle is on none."""

NEAR = 10.0
"""[m] within which lanes are looked for."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Beginning:
    """One scene's first frame.

    Attributes:
        counts: (4, BINS) in the order of RANGES. rates: (2,) in the order of RATES, NaN where nobody but the target stands.
        vehicles: how many stand there, the target included. recording: that the scene was cut from.
    """

    counts: Floats
    rates: Floats
    vehicles: int
    recording: str

    @classmethod
    def of(cls, scenario: Scenario, vehicles: Vehicles, graph: LaneGraph) -> "Beginning":
        """`vehicles`, the target first, on the map of `scenario`, whose `graph` is given."""
        others = np.arange(len(vehicles)) != TARGET
        heading, offset, off_lane = _on_lanes(graph, vehicles)
        gaps = [row for row in gaps_of(replace(scenario, vehicles=vehicles, log=None)) if row["vehicle"] != TARGET]
        values = {
            "speed": vehicles.speed[others],
            "gap": np.array([row["gap"] for row in gaps if np.isfinite(row["gap"])], np.float32),
            "heading": heading[others & ~off_lane],
            "offset": offset[others & ~off_lane],
        }
        rates = np.array([_overlapping(vehicles)[others].mean(), off_lane[others].mean()]) if others.any() else np.full(2, np.nan)
        counts = np.stack([binned(values[name], *ends) for name, ends in RANGES.items()])
        return cls(counts, rates, len(vehicles), recording(scenario.scenario_id))


def without_parked(scenario: Scenario) -> Scenario:
    """The scenario less whoever is parked beside the lanes, the target apart: nobody places such vehicles."""
    kept = ~parked(LaneGraph.of(scenario.map), scenario.vehicles)
    kept[TARGET] = True
    log = None if scenario.log is None else scenario.log[kept]
    return replace(scenario, vehicles=scenario.vehicles[kept], log=log)


def compared(logs: Sequence[Beginning], placed: Sequence[Beginning], draws: int, rng: np.random.Generator) -> dict[str, Interval]:
    """Distances to the logs by the names of RANGES, and rates of what was made; recordings are resampled."""
    times = resamplings([log.recording for log in logs], draws, rng)
    out = {}
    for q, (name, ends) in enumerate(RANGES.items()):
        pairs = np.stack([np.stack([log.counts[q], other.counts[q]]) for log, other in zip(logs, placed, strict=True)])
        out[name] = distance(pairs, *ends, times)
    return out | rates(placed, draws, rng)


def rates(placed: Sequence[Beginning], draws: int, rng: np.random.Generator) -> dict[str, Interval]:
    """Means over scenes by the names of RATES."""
    means = bootstrap_means(np.stack([one.rates for one in placed]), [one.recording for one in placed], draws, rng)
    return dict(zip(RATES, means, strict=True))


def _on_lanes(graph: LaneGraph, vehicles: Vehicles) -> tuple[NDArray[np.floating], NDArray[np.floating], NDArray[np.bool_]]:
    """Angles [deg] and offsets [m] (N,) to the nearest lane that runs a vehicle's way, else to the nearest; who is on none.

    A wrong way is an angle above 90 degrees, which goes to the last bin.
    """
    lane, numbers = graph.nearest(vehicles.position, vehicles.heading, NEAR, np.pi / 2)
    anyhow, instead = graph.nearest(vehicles.position, vehicles.heading, NEAR, np.pi)
    astray = (lane == NO_LANE) | (numbers[:, 3] > instead[:, 3] + _half_widths(graph, anyhow))
    lane, numbers = np.where(astray, anyhow, lane), np.where(astray[:, None], instead, numbers).astype(np.float64)
    angle = np.degrees(np.abs(wrap_angle(vehicles.heading - np.where(lane == NO_LANE, 0.0, numbers[:, 2]))))
    return angle, numbers[:, 3], numbers[:, 3] > _half_widths(graph, lane) + OFF_LANE


def _half_widths(graph: LaneGraph, lane: NDArray[np.int32]) -> Floats:
    """(N,) [m] half the mean width of lanes (N,), 0 for none."""
    half = graph.half_width.mean(axis=1)
    mean = np.array([half[low:high].mean() for low, high in zip(graph.line.start[:-1], graph.line.start[1:], strict=True)])
    return np.where(lane == NO_LANE, 0.0, mean[lane])


def _overlapping(vehicles: Vehicles) -> NDArray[np.bool_]:
    """(N,) whose box overlaps another's."""
    place, heading, size = vehicles.position.astype(np.float64), vehicles.heading, vehicles.size[:, :2]
    hit = boxes_overlap(place[:, None], heading[:, None], size[:, None], place, heading, size)
    np.fill_diagonal(hit, False)
    return np.asarray(hit.any(axis=1))
