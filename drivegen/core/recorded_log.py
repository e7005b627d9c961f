"""A log as it was recorded, before anyone chose a target: what every data set reader yields.

`selection.py` turns it into a `Scenario`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import Trajectories
from drivegen.core.signals import Signals

NO_TRACK = -1

MOST_CELLS = 20_000_000
"""More tracks times steps than this is a broken file, not a long recording (2 000 tracks for a quarter of an hour)."""

FARTHEST = 50_000.0
"""Nothing of a recording or its map is farther from the map's origin [m]: float32 would lose the centimetres."""

LONGEST = 100.0
"""Nothing on a road is longer or wider [m]."""


def expect_few_cells(tracks: int, steps: int, place: object) -> None:
    """Raise UnusableInput, reason `out-of-range`, naming `place`, for more than MOST_CELLS states."""
    if tracks * steps > MOST_CELLS:
        raise UnusableInput(f"{place} names {tracks} tracks over {steps} steps: cut it into shorter ones", reason="out-of-range")


@dataclass(frozen=True)
class RecordedLog:
    """All M tracks of one recording over its T steps, fragments included.

    Attributes:
        scenario_id: the recording's own id.
        source: data set in words, as it will stand in every table, e.g. "SUMO corpus (simulated)".
        city: city or network name.
        map: RoadMap in a local frame; tracks are in the same frame.
        track_id: (M,) str.
        kind: (M,) uint8 VehicleKind.
        size: (M, 3) float32 length, width, height [m]; NaN where the source has none.
        motion: Trajectories (M, T).
        focal: index of the focal track, NO_TRACK if there is none.
        ego: index of the recording vehicle ("AV"), NO_TRACK if there is none.
        signals: Signals over T steps.
        skipped: number of tracks left out by object type, e.g. {"static": 3}.
        per_hour: see `Scenario`.
    """

    scenario_id: str
    source: str
    city: str
    map: RoadMap
    track_id: NDArray[np.str_]
    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    motion: Trajectories
    focal: int
    ego: int
    signals: Signals
    skipped: dict[str, int]
    per_hour: float = 0.0
