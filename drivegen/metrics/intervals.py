"""Bootstrap intervals over scenarios: what a table's number would be on other scenarios of the same kind."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LEVEL = 0.95
"""Coverage of every interval in this project."""

_SCENE = re.compile(r"(-\d{5}-[^-]+|-\d{1,3})$")
"""What follows the recording in a scenario's id: first step and track in the corpus, a number where recordings are cut."""


@dataclass(frozen=True)
class Interval:
    """A statistic with its percentile bootstrap interval; all NaN where there is nothing to average."""

    value: float
    low: float
    high: float


def recording(scenario_id: str) -> str:
    """The recording that a scenario was cut from.

    Ids are `<file>-<number>` (CommonRoad: windows one after the other, several targets in each), `<log>-<window>` (Argoverse 2
    Sensor: windows overlap), `<network>-<part>-<run>-<first step>-<target>` (corpus: a run of SUMO is the recording) and a
    UUID (Argoverse 2 Motion Forecasting: a recording of its own). Scenes of one recording show the same vehicles, at the same
    time or some seconds later, so they are resampled together and never on both sides of a split.
    """
    return _SCENE.sub("", scenario_id)


def percentiles(draws: NDArray[np.floating]) -> tuple[float, float]:
    """The central `LEVEL` of bootstrap draws (D,)."""
    if len(draws) == 0:
        return np.nan, np.nan
    low, high = np.quantile(draws, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)


def resamplings(count: int, draws: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """How often each of `count` rows comes in each of D = `draws` bootstrap draws: (D, count).

    Multinomial counts, so that a mean over resampled rows is a product of matrices instead of `draws` copies of the table.
    """
    return rng.multinomial(count, np.full(count, 1 / count), size=draws).astype(np.float64)


def bootstrap_means(values: NDArray[np.floating], draws: int, rng: np.random.Generator) -> list[Interval]:
    """Mean and interval of each column of `values` (S, M), rows resampled together; NaN rows of a column don't count."""
    scenes = len(values)
    if scenes == 0:
        return [Interval(np.nan, np.nan, np.nan)] * values.shape[1]
    known = np.isfinite(values)
    filled = np.where(known, values, 0.0).astype(np.float64)
    times = resamplings(scenes, draws, rng)
    weight = times @ known
    means = np.divide(times @ filled, weight, out=np.full(weight.shape, np.nan), where=weight > 0)
    out = []
    for column in range(values.shape[1]):
        count = known[:, column].sum()
        drawn = means[:, column]
        value = float(filled[:, column].sum() / count) if count else np.nan
        out.append(Interval(value, *percentiles(drawn[np.isfinite(drawn)])))
    return out
