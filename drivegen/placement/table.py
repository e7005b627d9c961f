"""The table of vehicle assets (paper, vehicle assets generation): which vehicles there are, how large and how fast.

One row for each different box of a kind. Boxes measured in real logs come first, those of simulated logs (drawn from
documented classes) next; where a kind has neither, its documented size stands in. Every row says which it is.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario, SizeSource, VehicleKind, Vehicles

_MOVING = 1.0
"""Slower than this [m/s] says nothing about a vehicle's usual speed."""

_SIMULATED = "(simulated)"
"""Sources of simulated logs carry this word."""


class Provenance(IntEnum):
    """Where a row comes from, best first; nothing is placed from what was GENERATED, which is only compared with logs."""

    MEASURED = 0
    SIMULATED = 1
    DOCUMENTED = 2
    GENERATED = 3


_DOCUMENTED = {
    VehicleKind.CAR: ((4.63, 1.97, 1.74), 11.0),
    VehicleKind.TRUCK: ((6.93, 2.51, 2.84), 10.0),
    VehicleKind.BUS: ((10.5, 2.94, 3.47), 9.0),
}
"""Mean boxes of nuScenes' classes (Zhu et al., "Class-balanced grouping and sampling", 2019); speeds [m/s] assumed."""

_DOCUMENT = "mean boxes of nuScenes"

_SCHEMA = pa.schema(
    [
        ("kind", pa.uint8()),
        ("length", pa.float32()),
        ("width", pa.float32()),
        ("height", pa.float32()),
        ("usual_speed", pa.float32()),
        ("provenance", pa.uint8()),
        ("source", pa.string()),
        ("count", pa.int64()),
    ]
)


@dataclass(frozen=True)
class Table:
    """A rows of vehicles.

    Attributes:
        kind: (A,) uint8 VehicleKind. size: (A, 3) float32 length, width, height [m].
        usual_speed: (A,) float32 [m/s] median of the mean speeds of such vehicles while they moved.
        provenance: (A,) uint8. source: (A,) str data set in words. count: (A,) int64 tracks behind the row.
    """

    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    usual_speed: NDArray[np.float32]
    provenance: NDArray[np.uint8]
    source: NDArray[np.str_]
    count: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.kind)

    def to_arrow(self) -> pa.Table:
        """The rows as columns, for a Parquet file."""
        arrays = (self.kind, *self.size.T, self.usual_speed, self.provenance, self.source, self.count)
        return pa.Table.from_arrays([pa.array(a) for a in arrays], schema=_SCHEMA)

    @classmethod
    def from_arrow(cls, table: pa.Table, place: str) -> "Table":
        """The inverse of `to_arrow`. Raises UnusableInput, naming `place`, for anything else."""
        try:
            columns = {field.name: table[field.name].cast(field.type).to_numpy() for field in _SCHEMA}
        except (KeyError, pa.ArrowException) as error:
            raise UnusableInput(f"{place} is no table of vehicle assets: {error}", reason="bad-assets") from None
        size = np.stack([columns["length"], columns["width"], columns["height"]], axis=-1)
        kinds = np.array([int(kind) for kind in VehicleKind])
        if not len(size) or not (size > 0).all() or not np.isin(columns["kind"], kinds).all():
            raise UnusableInput(f"{place} has no assets, or one without a size or kind", reason="bad-assets")
        words = columns["source"].astype(np.str_)
        return cls(columns["kind"], size, columns["usual_speed"], columns["provenance"], words, columns["count"])


def build_table(scenarios: Iterable[Scenario]) -> Table:
    """The assets that appear in the logs of `scenarios`, and documented ones for planned kinds that do not appear."""
    speeds: dict[tuple[int, int, tuple[float, ...], str], list[float]] = {}
    for scenario in scenarios:
        pace = _usual_speeds(scenario)
        for i, known_by in enumerate(_provenances(scenario.vehicles, provenance_of_log(scenario.source))):
            if known_by is not None:
                size = tuple(np.round(scenario.vehicles.size[i].astype(np.float64), 2).tolist())
                key = (int(scenario.vehicles.kind[i]), int(known_by), size, scenario.source)
                speeds.setdefault(key, []).append(float(pace[i]))
    for documented, (box, pace_of_kind) in _DOCUMENTED.items():
        if not any(key[0] == documented for key in speeds):
            speeds[(int(documented), int(Provenance.DOCUMENTED), box, _DOCUMENT)] = [pace_of_kind]
    keys = sorted(speeds)
    kinds, provenance, sizes, sources = zip(*keys, strict=True)
    kind = np.array(kinds, np.uint8)
    return Table(
        kind=kind,
        size=np.array(sizes, np.float32),
        usual_speed=_filled(kind, np.array([_median(speeds[key]) for key in keys], np.float32)),
        provenance=np.array(provenance, np.uint8),
        source=np.array(sources, np.str_),
        count=np.array([len(speeds[key]) for key in keys], np.int64),
    )


def provenance_of_log(source: str) -> Provenance:
    """Of what is seen in the logs of `source`, a data set in words."""
    return Provenance.SIMULATED if _SIMULATED in source else Provenance.MEASURED


def _provenances(vehicles: Vehicles, of_log: Provenance) -> list[Provenance | None]:
    """Of each vehicle's box; None for boxes that were shrunk."""
    provenance = {SizeSource.MEASURED: of_log, SizeSource.ASSUMED: Provenance.DOCUMENTED}
    return [provenance.get(SizeSource(int(source))) for source in vehicles.size_source]


def _usual_speeds(scenario: Scenario) -> NDArray[np.float64]:
    """(N,) mean speed [m/s] over the steps at which each vehicle moves; NaN where it never does."""
    if scenario.log is None:
        return np.where(scenario.vehicles.speed > _MOVING, scenario.vehicles.speed, np.nan).astype(np.float64)
    speed = scenario.log.speed
    moving = scenario.log.valid & (speed > _MOVING)
    count = moving.sum(-1)
    return np.where(count > 0, np.where(moving, speed, 0.0).sum(-1) / np.maximum(count, 1), np.nan)


def _median(speeds: list[float]) -> float:
    finite = [speed for speed in speeds if np.isfinite(speed)]
    return float(np.median(finite)) if finite else float("nan")


def _filled(kind: NDArray[np.uint8], speed: NDArray[np.float32]) -> NDArray[np.float32]:
    """Speeds with the median of the kind, else the documented one, where a vehicle was never seen to move."""
    filled = speed.copy()
    for i in np.flatnonzero(~np.isfinite(speed)).tolist():
        same = speed[(kind == kind[i]) & np.isfinite(speed)]
        documented = _DOCUMENTED.get(VehicleKind(int(kind[i])), ((), 10.0))[1]
        filled[i] = np.median(same) if len(same) else documented
    return filled
