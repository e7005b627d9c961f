"""Where vehicles of logged traffic stand, how fast they are and how closely they follow. What placement from data draws from.

One row for each vehicle at the first frame of a training log, with its provenance. The leader is the nearest vehicle ahead
in the same lane or in one that it leads to, among those of the scenario: gaps to vehicles that the scenario does not hold
are not seen, so the row says "no leader" where the road is free up to the next vehicle of the scenario.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET, Scenario, VehicleKind
from drivegen.placement.table import Provenance, provenance_of_log
from drivegen.placement.ways import REACH, Ways, blocked, closed_lanes, limits, to_junction
from drivegen.roads.graph import LaneGraph

ON_LANE, ALONG_LANE = 2.0, np.deg2rad(45)
"""A vehicle is on a lane up to this far from its centreline [m] if it heads along it within this angle [rad]."""

_SCHEMA = pa.schema(
    [
        ("kind", pa.uint8()),
        ("speed", pa.float32()),
        ("limit", pa.float32()),
        ("gap", pa.float32()),
        ("leader_speed", pa.float32()),
        ("to_junction", pa.float32()),
        ("closed", pa.bool_()),
        ("away", pa.float32()),
        ("offset", pa.float32()),
        ("provenance", pa.uint8()),
        ("source", pa.string()),
        ("scenario_id", pa.string()),
    ]
)


@dataclass(frozen=True)
class Gaps:
    """G vehicles on lanes.

    Attributes:
        kind: (G,) uint8 VehicleKind. speed: (G,) float32 [m/s]. limit: (G,) float32 [m/s] of its lane.
        gap: (G,) float32 [m] bumper to bumper to the leader, inf without one within REACH.
        leader_speed: (G,) float32 [m/s], NaN without a leader.
        to_junction: (G,) float32 [m] along its lanes to where a junction begins, inf where none does within REACH, 0 inside.
        closed: (G,) bool whether its lane leads only into lanes that must not be entered, as before a red light.
        away: (G,) float32 [m] from the scenario's target, 0 of the target itself.
        offset: (G,) float32 [m] to the left of the middle of its lane.
        provenance: (G,) uint8. source: (G,) str data set in words. scenario_id: (G,) str the log that it was seen in.
    """

    kind: NDArray[np.uint8]
    speed: NDArray[np.float32]
    limit: NDArray[np.float32]
    gap: NDArray[np.float32]
    leader_speed: NDArray[np.float32]
    to_junction: NDArray[np.float32]
    closed: NDArray[np.bool_]
    away: NDArray[np.float32]
    offset: NDArray[np.float32]
    provenance: NDArray[np.uint8]
    source: NDArray[np.str_]
    scenario_id: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.speed)

    @property
    def led(self) -> NDArray[np.bool_]:
        """(G,) who has a leader."""
        return np.isfinite(self.gap)

    @property
    def pace(self) -> NDArray[np.float64]:
        """(G,) speed as a share of the limit."""
        return np.asarray(self.speed / np.maximum(self.limit, 1.0), np.float64)

    def __getitem__(self, index: Any) -> "Gaps":
        return Gaps(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    def to_arrow(self) -> pa.Table:
        """The rows as columns, for a Parquet file."""
        arrays = [pa.array(getattr(self, field.name)).cast(field.type) for field in _SCHEMA]
        return pa.Table.from_arrays(arrays, schema=_SCHEMA)

    @classmethod
    def from_arrow(cls, table: pa.Table, place: str) -> "Gaps":
        """The inverse of `to_arrow`. Raises UnusableInput, naming `place`, for anything else and for no row with a leader."""
        try:
            columns = {field.name: table[field.name].cast(field.type).to_numpy() for field in _SCHEMA}
        except (KeyError, pa.ArrowException) as error:
            sentence = f"{place} is no table of gaps of this version, run the assets stage: {error}"
            raise UnusableInput(sentence, reason="bad-gaps") from None
        texts = {name: columns[name].astype(np.str_) for name in ("source", "scenario_id")}
        gaps = cls(**{**columns, **texts})
        if not gaps.led.any():
            raise UnusableInput(f"{place} holds no vehicle with a leader: run the assets stage on more logs", reason="bad-gaps")
        return gaps


def measure_gaps(scenarios: Iterable[Scenario]) -> Gaps:
    """The rows of all vehicles of `scenarios` that stand on lanes at the first frame."""
    rows = [row for scenario in scenarios for row in gaps_of(scenario)]
    columns: dict[str, Any] = {name: [row[name] for row in rows] for name in _SCHEMA.names}
    types: Mapping[str, Any] = {
        "kind": np.uint8,
        "provenance": np.uint8,
        "closed": np.bool_,
        "source": np.str_,
        "scenario_id": np.str_,
    }
    return Gaps(**{name: np.array(values, types.get(name, np.float32)) for name, values in columns.items()})


def gaps_of(scenario: Scenario) -> list[dict[str, Any]]:
    """One row for each car, truck and bus of the scenario that is on a lane, as in `Gaps`, and its number, `vehicle`."""
    vehicles = scenario.vehicles
    graph, ways = LaneGraph.of(scenario.map), Ways(scenario.map)
    lane, numbers = graph.nearest(vehicles.position, vehicles.heading, ON_LANE, ALONG_LANE)
    planned = np.isin(vehicles.kind, (VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS))
    on_lane = np.flatnonzero((lane >= 0) & planned)
    lanes, alongs, length = lane[on_lane], numbers[on_lane, 0].astype(np.float64), vehicles.size[on_lane, 0]
    limit = limits(scenario.map)[lanes]
    shut = blocked(ways, closed_lanes(scenario.signals))[lanes]
    ahead = to_junction(scenario.map, ways)[lanes] + np.maximum(ways.length[lanes] - alongs, 0.0)
    junction = np.where(scenario.map.in_junction[lanes], 0.0, ahead)
    from_target = np.hypot(*(vehicles.position[on_lane] - vehicles.position[TARGET]).T)
    rows = []
    for at, vehicle in enumerate(on_lane.tolist()):
        away = ways.ahead(int(lanes[at]), float(alongs[at]), lanes, alongs)
        away[at] = np.inf
        leader = int(np.argmin(away))
        gap = float(away[leader] - (length[at] + length[leader]) / 2)
        led = away[leader] <= REACH and gap > 0.0
        rows.append(
            {
                "vehicle": vehicle,
                "kind": vehicles.kind[vehicle],
                "speed": vehicles.speed[vehicle],
                "limit": limit[at],
                "gap": gap if led else np.inf,
                "leader_speed": vehicles.speed[on_lane[leader]] if led else np.nan,
                "to_junction": junction[at],
                "closed": shut[at],
                "away": from_target[at],
                "offset": numbers[vehicle, 1],
                "provenance": Provenance.GENERATED if scenario.log is None else provenance_of_log(scenario.source),
                "source": scenario.source,
                "scenario_id": scenario.scenario_id,
            }
        )
    return rows


SLOW = 1.0
"""Up to this speed [m/s] a gap is one of a standing queue; STANDSTILL [m] stands in for it where no queue was seen."""

STANDSTILL = 1.0

LONGEST = 10.0
"""Longer time gaps [s] say nothing of following."""


@dataclass(frozen=True)
class Following:
    """Of vehicles on lanes, all that headways are taken of: gap (G,) float32 [m], inf without a leader, speed (G,) [m/s]."""

    gap: NDArray[np.float32]
    speed: NDArray[np.float32]

    @classmethod
    def of(cls, scenarios: Iterable[Scenario]) -> "Following":
        """Of all vehicles of `scenarios` at the first frame, scenario by scenario."""
        parts = [np.zeros((2, 0), np.float32)]
        for scenario in scenarios:
            gaps = measure_gaps([scenario])
            parts.append(np.stack([gaps.gap, gaps.speed]))
        return cls(*np.concatenate(parts, axis=1))


def headways(gaps: Following, truth: Following | None = None) -> dict[str, Any]:
    """What can be compared of gaps: counts, medians, 41 quantiles of the time gap [s] of moving vehicles with a leader.

    `distance` is the Wasserstein-1 distance [s] between their time gaps and those of `truth`: the mean difference of quantiles.
    """
    own, led = _time_gaps(gaps), np.isfinite(gaps.gap)
    share = np.linspace(0.0, 1.0, 41)
    numbers: dict[str, Any] = {
        "vehicles": len(led),
        "led": float(led.mean()) if len(led) else 0.0,
        "gap_median": float(np.median(gaps.gap[led])) if led.any() else None,
        "time_gap_median": float(np.median(own)) if len(own) else None,
        "time_gap": np.quantile(own, share).round(3).tolist() if len(own) else [],
    }
    if truth is not None and len(own) and len(true := _time_gaps(truth)):
        fine = np.linspace(0.0, 1.0, 1001)
        numbers["distance"] = float(np.abs(np.quantile(own, fine) - np.quantile(true, fine)).mean())
    return numbers


def _time_gaps(gaps: Following) -> NDArray[np.float64]:
    led = np.isfinite(gaps.gap) & (gaps.speed > 1.0)
    seconds = (gaps.gap[led] / gaps.speed[led]).astype(np.float64)
    return np.asarray(seconds[seconds <= LONGEST])
