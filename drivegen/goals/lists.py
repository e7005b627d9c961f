"""What a ranker learns from: the candidates of many vehicles as lists, with where each vehicle ended in its log."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario
from drivegen.core.twins import twin
from drivegen.goals.candidates import MOST, Candidates, candidates_on, routes_of
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.features import NAMES, features
from drivegen.goals.labels import ends
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import with_limits
from drivegen.store.columns import Starts, joined


@dataclass(frozen=True)
class Lists:
    """V lists to learn from, end to end, N candidates in all; a table of columns, which may be mapped.

    Attributes:
        start: (V + 1,) first candidate of each list, and N. x: (N, F) features. prior: (N,) mass of the candidates.
        distance: (N,) [m] from the logged end. doubt: (V,) [m] standard deviation of that end, 0 where it was seen.
        taught: (N,) a teacher's odds, which are the label then; all zero where the log is.
    """

    start: Annotated[NDArray[np.int64], Starts("x")]
    x: NDArray[np.float32]
    prior: NDArray[np.float32]
    distance: NDArray[np.float32]
    doubt: NDArray[np.float32]
    taught: NDArray[np.float32]

    @classmethod
    def none(cls) -> "Lists":
        """No list."""
        empty = np.zeros(0, np.float32)
        return cls(np.zeros(1, np.int64), np.zeros((0, len(NAMES)), np.float32), empty, empty, empty, empty)

    @classmethod
    def of(cls, scenario: Scenario, candidates: Sequence[Candidates]) -> "Lists":
        """Those of all vehicles whose logged end can be a label."""
        labels = ends(scenario, candidates)
        if len(labels.vehicle) == 0:
            return cls.none()
        features_of, labelled = features(first_frame(scenario), candidates), labels.vehicle.tolist()
        away = [np.hypot(*(candidates[n].position - end).T) for n, end in zip(labelled, labels.position, strict=True)]
        distance = np.concatenate(away).astype(np.float32)
        chosen, x = [candidates[n] for n in labelled], np.concatenate([features_of[n] for n in labelled])
        return cls._of(chosen, x, distance, labels.doubt.astype(np.float32), np.zeros_like(distance))

    @classmethod
    def of_log(cls, log: Scenario, settings: CandidateSettings) -> "Lists":
        """Those of a log and of its twin, which has fewer layers: the same ways, but for their limits."""
        graph, parts = LaneGraph.of(log.map), []
        routes = [routes_of(graph, log, n, settings) for n in range(len(log.vehicles))]
        for scenario in (log, twin(log)):
            ways = [[with_limits(route, scenario.map.speed_limit) for route in one] for one in routes]
            parts.append(cls.of(scenario, [candidates_on(way, scenario, n, settings) for n, way in enumerate(ways)]))
        return joined(cls, parts)

    @classmethod
    def by_teacher(cls, scenario: Scenario, candidates: Sequence[Candidates], odds: Sequence[NDArray[np.float32]]) -> "Lists":
        """Those of all vehicles, labelled with a teacher's `odds` (C,); whether there is a log does not matter."""
        x, taught = np.concatenate(features(first_frame(scenario), candidates)), np.concatenate(odds)
        return cls._of(candidates, x, np.zeros_like(taught), np.zeros(len(candidates), np.float32), taught)

    @classmethod
    def _of(cls, candidates: Sequence[Candidates], x: NDArray[np.float32], *columns: NDArray[np.float32]) -> "Lists":
        """Of the lists' candidates and the columns x, distance, doubt, taught."""
        start = np.cumsum([0, *map(len, candidates)])
        return cls(start, x, np.concatenate([c.prior for c in candidates]), *columns)

    def __len__(self) -> int:
        return len(self.doubt)

    def padded(self, rows: NDArray[np.integer]) -> "Padded":
        """The lists `rows` (b,)."""
        pad = Padding.of(self.start, rows)
        x, prior, taught = pad(self.x), pad(self.prior), pad(self.taught)
        return Padded(pad.there, x, prior, np.where(pad.there, pad(self.distance), np.inf), self.doubt[rows], taught)


@dataclass(frozen=True)
class Padded:
    """Lists as `Lists` has them, b rows of MOST candidates: `there` (b, MOST); `distance` is inf for none."""

    there: NDArray[np.bool_]
    x: NDArray[np.float32]
    prior: NDArray[np.float32]
    distance: NDArray[np.float32]
    doubt: NDArray[np.float32]
    taught: NDArray[np.float32]


@dataclass(frozen=True)
class Padding:
    """`padding(column)` are the values (b, MOST, ...) of b lists of a column (N, ...), zero where a list has ended.

    Attributes:
        there: (b, MOST). at: rows of the column, one for each place that is there.
    """

    there: NDArray[np.bool_]
    at: NDArray[np.integer]

    @classmethod
    def of(cls, start: NDArray[np.integer], rows: NDArray[np.integer]) -> "Padding":
        """Of the lists `rows` (b,) whose candidates begin at `start`. Raises UnusableInput for a list longer than MOST."""
        count = start[rows + 1] - start[rows]
        if (longest := count.max(initial=0)) > MOST:
            raise UnusableInput(f"a vehicle has {longest} candidates, the learned selector ranks {MOST} at most")
        there = np.arange(MOST) < count[:, None]
        return cls(there, (start[rows, None] + np.arange(MOST))[there])

    def __call__(self, column: NDArray[np.float32]) -> NDArray[np.float32]:
        """See the class."""
        out = np.zeros((*self.there.shape, *column.shape[1:]), column.dtype)
        out[self.there] = column[self.at]
        return out
