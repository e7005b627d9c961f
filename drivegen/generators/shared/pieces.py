"""Lane centrelines cut into pieces of nearly equal length, without a loop over lanes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Polylines
from drivegen.core.roadmap import LaneControl, LaneKind
from drivegen.core.scenario import Scenario
from drivegen.core.signals import SignalState

PIECE = 15.0
"""[m] A centreline is cut into equal pieces no longer than this."""

POINTS = 4
"""Points of a piece, equally spaced, both ends included."""

NO_LIMIT = 13.9
"""[m/s] stands for an unknown speed limit; a flag beside it says so."""

FEATURES = 2 + 1 + 1 + len(LaneControl) + len(SignalState)
"""Of each piece: speed limit [10 m/s] and whether it is known, in a junction, for buses, control of its lane (one-hot),
state of its lane's signal at step 0 (one-hot; UNKNOWN where it has none)."""


@dataclass(frozen=True)
class Pieces:
    """P pieces of the maps of many scenarios, scenario by scenario.

    Attributes:
        points: (P, POINTS, 2) float32 [m] in driving direction, in each scenario's own map frame.
        features: (P, FEATURES) float32.
        start: (S + 1,) first piece of each scenario, and P at the end.
    """

    points: NDArray[np.float32]
    features: NDArray[np.float32]
    start: NDArray[np.intp]

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> "Pieces":
        """The pieces of all lanes for vehicles."""
        points, features = [], []
        for scenario in scenarios:
            cut, lane = _cut(scenario.map.centreline)
            keep = scenario.map.for_vehicles[lane]
            points.append(cut[keep])
            features.append(_lane_features(scenario)[lane[keep]])
        return cls(np.concatenate(points), np.concatenate(features), np.cumsum([0, *map(len, points)]))


def _cut(lines: Polylines) -> tuple[NDArray[np.float32], NDArray[np.intp]]:
    """Points (P, POINTS, 2) of all pieces, and the line (P,) that each is of."""
    count = len(lines)
    step = np.hypot(*np.diff(lines.points.astype(np.float64), axis=0).T)
    step[lines.start[1:-1] - 1] = 0.0  # from one line's end to the next one's beginning
    along = np.concatenate([[0.0], np.cumsum(step)])
    begin, end = along[lines.start[:-1]], along[lines.start[1:] - 1]
    pieces = np.maximum(np.ceil((end - begin) / PIECE - 1e-6), 1).astype(np.intp)
    line = np.repeat(np.arange(count), pieces)
    number = np.arange(len(line)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    length = ((end - begin) / pieces)[line]
    wanted = begin[line, None] + length[:, None] * (number[:, None] + np.linspace(0.0, 1.0, POINTS))
    # an own stretch of the axis for each line, so that interpolation never runs from one into the next
    gap = np.arange(count) * 1.0
    axis = along + np.repeat(gap, np.diff(lines.start))
    at = (np.clip(wanted, begin[line, None], end[line, None]) + gap[line, None]).reshape(-1)
    points = np.stack([np.interp(at, axis, lines.points[:, i]) for i in (0, 1)], axis=-1)
    return points.reshape(-1, POINTS, 2).astype(np.float32), line


def _lane_features(scenario: Scenario) -> NDArray[np.float32]:
    """(L, FEATURES) of every lane."""
    roads, signals = scenario.map, scenario.signals
    state = np.full(len(roads), SignalState.UNKNOWN, np.intp)
    state[signals.lane] = signals.state[:, 0]
    unknown = np.isnan(roads.speed_limit)
    columns = [
        np.where(unknown, NO_LIMIT, roads.speed_limit)[:, None] / 10.0,
        np.stack([~unknown, roads.in_junction, np.equal(roads.kind, LaneKind.BUS)], axis=1),
        np.eye(len(LaneControl))[roads.control],
        np.eye(len(SignalState))[state],
    ]
    return np.concatenate(columns, axis=1).astype(np.float32)
