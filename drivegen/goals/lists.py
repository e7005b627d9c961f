"""What a ranker learns from: the candidates of many vehicles as padded lists, with where each vehicle ended in its log."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import MOST, Candidates, candidates_on, routes_of
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.features import NAMES, features
from drivegen.goals.labels import ends
from drivegen.goals.twins import twin
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import with_limits


@dataclass(frozen=True)
class Lists:
    """V lists to learn from, padded.

    Attributes:
        x: (V, MOST, F) features. distance: (V, MOST) [m] of candidates from the logged end, inf for none.
        doubt: (V,) [m] standard deviation of that end, 0 where it was seen.
        prior: (V, MOST) mass of the candidates.
        taught: (V, MOST) a teacher's odds, which are the label then; all zero where the log is.
    """

    x: NDArray[np.float32]
    prior: NDArray[np.float32]
    distance: NDArray[np.float32]
    doubt: NDArray[np.float32]
    taught: NDArray[np.float32]

    @classmethod
    def none(cls) -> "Lists":
        """No list."""
        empty = np.zeros((0, MOST), np.float32)
        return cls(np.zeros((0, MOST, len(NAMES)), np.float32), empty, empty, empty[:, 0], empty)

    @classmethod
    def of(cls, scenario: Scenario, candidates: Sequence[Candidates]) -> "Lists":
        """Those of all vehicles whose logged end can be a label."""
        labels = ends(scenario, candidates)
        if len(labels.vehicle) == 0:
            return cls.none()
        features_of, labelled = features(first_frame(scenario), candidates), labels.vehicle.tolist()
        x, there = padded([features_of[n] for n in labelled])
        distance = np.full(there.shape, np.inf, np.float32)
        for i, n in enumerate(labelled):
            distance[i, : len(candidates[n])] = np.hypot(*(candidates[n].position - labels.position[i]).T)
        prior = padded_odds([candidates[n].prior for n in labelled])
        return cls(x, prior, distance, labels.doubt.astype(np.float32), np.zeros_like(distance))

    @classmethod
    def of_log(cls, log: Scenario, settings: CandidateSettings) -> "Lists":
        """Those of a log and of its twin, which has fewer layers: the same ways, but for their limits."""
        graph, parts = LaneGraph.of(log.map), []
        routes = [routes_of(graph, log, n, settings) for n in range(len(log.vehicles))]
        for scenario in (log, twin(log)):
            ways = [[with_limits(route, scenario.map.speed_limit) for route in one] for one in routes]
            parts.append(cls.of(scenario, [candidates_on(way, scenario, n, settings) for n, way in enumerate(ways)]))
        return cls.joined(parts)

    @classmethod
    def by_teacher(cls, scenario: Scenario, candidates: Sequence[Candidates], odds: Sequence[NDArray[np.float32]]) -> "Lists":
        """Those of all vehicles, labelled with a teacher's `odds` (C,); whether there is a log does not matter."""
        x, there = padded(features(first_frame(scenario), candidates))
        distance = np.where(there, 0.0, np.inf).astype(np.float32)
        return cls(x, padded_odds([c.prior for c in candidates]), distance, np.zeros(len(x), np.float32), padded_odds(odds))

    @classmethod
    def joined(cls, parts: "Sequence[Lists]") -> "Lists":
        """All of them, in order."""
        return cls(*(np.concatenate([getattr(p, name) for p in parts]) for name in cls.__dataclass_fields__))

    def __len__(self) -> int:
        return len(self.x)


def padded_odds(lists: Sequence[NDArray[np.float32]]) -> NDArray[np.float32]:
    """(V, MOST) of lists that are no longer than that, zero where they end."""
    table = np.zeros((len(lists), MOST), np.float32)
    for row, values in zip(table, lists, strict=True):
        row[: len(values)] = values
    return table


def padded(lists: Sequence[NDArray[np.float32]]) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """x (V, MOST, F), there (V, MOST). Raises UnusableInput where a list is longer than MOST."""
    x = np.zeros((len(lists), MOST, len(NAMES)), np.float32)
    there = np.zeros((len(lists), MOST), np.bool_)
    for i, values in enumerate(lists):
        if len(values) > MOST:
            raise UnusableInput(f"a vehicle has {len(values)} candidates, the learned selector ranks {MOST} at most")
        x[i, : len(values)], there[i, : len(values)] = values, True
    return x, there
