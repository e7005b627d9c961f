"""Bootstrap intervals over recordings: what a table's number would be on other recordings of the same kind.

Which scenes are resampled together, and which are averaged, is said here for all tables. Percentile intervals of few recordings
are too narrow: of normal figures they hold the true mean in 50 % of cases with 2 recordings, 73 % with 3, 82 % with 5, 89 %
with 10, 92 % with 14, 93 % with 40.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

LEVEL = 0.95
"""Coverage of every interval in this project."""

_SCENE = re.compile(r"(-\d{5}-[^-]+|-\d+-\d{4,}|-\d{1,3})$")
"""What follows the recording in a scenario's id: first step and track in the corpus, seed and number on new maps, a number where
recordings are cut. Ids of one's own are read likewise (`docs/data.md`)."""

_MADE = re.compile(r"(-s\d{2,}|-new)+$")
"""What follows a scenario's id where a future of it, or new vehicles on its road, became a scenario of its own."""


@dataclass(frozen=True)
class Interval:
    """A statistic with its percentile bootstrap interval; all NaN where there is nothing to average.

    Low and high are NaN, too, where all is from one recording: it says nothing about others. Where both are the value itself no
    recording differs from the others, as with a share of 0, and resampling says nothing either: tables then print no ends.
    """

    value: float
    low: float
    high: float


_NGSIM = {
    "USA_Lanker-2_13_T-1": ("USA_Lanker-2_14_T-1",),
    "USA_Lanker-2_16_T-1": ("USA_Lanker-2_19_T-1", "USA_Lanker-2_21_T-1"),
    "USA_US101-5_1_T-1": ("USA_US101-15_1_T-1",),
    "USA_US101-6_1_T-1": tuple(f"USA_US101-{n}_1_T-1" for n in (7, 9, 20, 25, 28)),
    "USA_US101-12_1_T-1": ("USA_US101-17_1_T-1",),
}
_GROUP = {file: group for group, files in _NGSIM.items() for file in files}
"""Recordings of NGSIM in CommonRoad that show the same cars at overlapping times (found by equal sequences of speeds), and the
one that stands for all: of 28 recordings there are 18 groups that share no cars."""


def recording(scenario_id: str) -> str:
    """The recording that a scenario was cut from, the same for recordings that share vehicles.

    Ids are `<file>-<number>` (CommonRoad: windows one after the other, several targets in each), `<log>-<window>` (Argoverse 2
    Sensor: windows overlap), `<network>-<part>-<run>-<first step>-<target>` (corpus: a run of SUMO is the recording) and a UUID
    (Argoverse 2 Motion Forecasting: a recording of its own). Where vehicles were placed on a map it is `<map>-<seed>-<number>`,
    and the map stands for the recording: it is one road. Scenes of one recording show the same vehicles, at the same time or some
    seconds later, so they are resampled together and never on both sides of a split. What was generated from a scenario and has
    become one of its own (`<id>-s<number>`, `<id>-new`) is of the same recording.
    """
    return group_of(_SCENE.sub("", _MADE.sub("", scenario_id)))


def group_of(name: str) -> str:
    """The recording that stands for all that show the same cars as the one of this name."""
    return _GROUP.get(name, name)


def usual_length(steps: NDArray[np.generic]) -> int:
    """The number of steps that most scenes have, from those of each (S,); of several the largest.

    Only scenes of one length are averaged: errors grow with the time that is foreseen.
    """
    lengths, count = np.unique(steps, return_counts=True)
    return int(lengths[count == count.max()][-1])


def percentiles(draws: NDArray[np.floating]) -> tuple[float, float]:
    """The central `LEVEL` of bootstrap draws (D,)."""
    if len(draws) == 0:
        return np.nan, np.nan
    low, high = np.quantile(draws, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)


def counts(count: int, draws: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """How often each of `count` things comes in each of D = `draws` bootstrap draws: (D, count).

    Multinomial counts, so that a mean over resampled rows is a product of matrices instead of `draws` copies of the table.
    """
    return rng.multinomial(count, np.full(count, 1 / count), size=draws).astype(np.float64)


ROWS = 4096
"""Rows that are resampled at once: sums of fewer have the same bits as in one product of matrices."""


@dataclass(frozen=True)
class Draws:
    """Bootstrap draws of recordings: of D draws how often each of R recordings comes, and the recording of each of S rows.

    Attributes:
        times: (D, R) float64. number: (S,) int.
    """

    times: NDArray[np.float64]
    number: NDArray[np.intp]

    @classmethod
    def of(cls, recordings: Sequence[str], draws: int, rng: np.random.Generator) -> "Draws":
        """`draws` draws of the distinct names in `recordings`, one name a row; none where there is one recording alone."""
        names, number = np.unique(np.asarray(recordings), return_inverse=True)
        return cls(counts(len(names), draws if len(names) > 1 else 0, rng), number)

    def sums(self, parts: Iterable[NDArray[np.float64]]) -> NDArray[np.float64]:
        """(D, ...) sums over the rows of each draw; values (S, ...) come in parts, one after the other."""
        total, row = np.zeros(0), 0
        for part in parts:
            times = self.times[:, self.number[row : row + len(part)]]
            sums = (times @ part.reshape(len(part), -1)).reshape(len(times), *part.shape[1:])
            total, row = (total + sums if row else sums), row + len(part)
        return total


def stacked(values: Iterable[NDArray[np.float64]]) -> Iterator[NDArray[np.float64]]:
    """The values of all rows in parts (s, ...) of at most ROWS."""
    rows = iter(values)
    while part := list(islice(rows, ROWS)):
        yield np.stack(part)


def resamplings(recordings: Sequence[str], draws: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """How often each row comes in each of D draws of the distinct names in `recordings`, one name a row: (D, len(recordings)).

    Rows of one recording come equally often (cluster bootstrap). Of one recording alone there are no draws: D = 0.
    """
    drawn = Draws.of(recordings, draws, rng)
    return drawn.times[:, drawn.number]


def bootstrap_means(
    values: NDArray[np.floating], recordings: Sequence[str], draws: int, rng: np.random.Generator
) -> list[Interval]:
    """Mean and interval of each column of `values` (S, M); NaN rows of a column don't count.

    Rows are resampled together with all others of their recording.
    """
    scenes = len(values)
    if scenes == 0:
        return [Interval(np.nan, np.nan, np.nan)] * values.shape[1]
    finite = np.isfinite(values)
    drawn = Draws.of(recordings, draws, rng)
    parts = [slice(low, low + ROWS) for low in range(0, scenes, ROWS)]
    weight = drawn.sums(finite[part].astype(np.float64) for part in parts)
    total = drawn.sums(np.where(finite[part], values[part], 0.0).astype(np.float64) for part in parts)
    means = np.divide(total, weight, out=np.full(weight.shape, np.nan), where=weight > 0)
    out = []
    for column in range(values.shape[1]):
        known = finite[:, column]
        of_column = means[:, column]
        value = float(np.where(known, values[:, column], 0.0).astype(np.float64).sum() / known.sum()) if known.any() else np.nan
        several = len(np.unique(drawn.number[known])) > 1
        out.append(Interval(value, *percentiles(of_column[np.isfinite(of_column) & several])))
    return out
