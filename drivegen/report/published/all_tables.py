"""All tables of scenario quality: of each data set alone, of pairs of them, and over all of them."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from drivegen.core.methods import Method
from drivegen.core.seeds import rng
from drivegen.report.published import quality
from drivegen.report.published.additions import added
from drivegen.report.published.best import best
from drivegen.report.published.costs import costs
from drivegen.report.published.front import front
from drivegen.report.published.goals import goals
from drivegen.report.published.results import DataSet, Pooled
from drivegen.report.published.runs import read_goal_metrics, read_temperatures, read_took, read_trained
from drivegen.report.published.training import models
from drivegen.report.table import Table
from drivegen.warehouse.runs import read_param

PooledSets = Mapping[str, tuple[DataSet, Pooled]]
"""Data sets that were run, with their intervals, by name."""


def tables_of(
    data: DataSet, pooled: Pooled, folder: Path, temperatures: Sequence[float], selectors: Sequence[str], draws: int, seed: int
) -> list[Table]:
    """All tables of one data set alone, the headline first.

    `folder` holds its runs. `temperatures` are those beside the one in use at which DriveGen was run, if any; `selectors` is the
    order of rows where goals are compared. `draws` bootstrap draws by `seed`.
    """

    def stream() -> np.random.Generator:  # the same for every table: one difference has one interval
        return rng(seed, "publish", data.name)

    first, paired, *others = quality.tables(data, pooled, draws, stream())
    tables = [first, paired, *best(data, pooled, draws, stream()), *others]
    if at := read_temperatures(folder, temperatures):
        tables.append(front(data, at, pooled, read_param(folder / data.runs[0].folder, "rollout.generation.temperature")))
    tables += added(data, pooled, draws, stream())
    if goal_metrics := read_goal_metrics(folder, data.runs):
        tables.append(goals(data.name, data.title, selectors, goal_metrics))
    return quality.few(data, tables)


def transfers(pooled_sets: PooledSets, pairs: Iterable[Sequence[str]]) -> list[Table]:
    """The order of the methods on pairs of data sets; pairs of which one was not run are left out."""
    return [
        quality.transfer(*pooled_sets[one], *pooled_sets[other])
        for one, other in pairs
        if one in pooled_sets and other in pooled_sets
    ]


def trainings(pooled_sets: PooledSets, pairs: Iterable[Sequence[str]], draws: int, seed: int) -> list[Table]:
    """The same scenes by models that learnt from less and from more; pairs of which one was not run are left out."""
    tables: list[Table] = []
    for less, more in pairs:
        if less in pooled_sets and more in pooled_sets:
            stream = rng(seed, "publish", "training", more)
            table = quality.training(pooled_sets[less][0], pooled_sets[more][0], draws, stream)
            tables += quality.few(pooled_sets[more][0], [table])
    return tables


def models_and_costs(pooled_sets: PooledSets, runs: Path, about: Mapping[str, Method]) -> list[Table]:
    """What was trained in all runs below `runs`, and what scenarios cost on the data set with the most scenes.

    `about` is every generator in the tables' order.
    """
    data_sets = [data for data, _ in pooled_sets.values()]
    most = max(data_sets, key=lambda data: data.scenes)
    samples = read_param(runs / most.name / most.runs[0].folder, "rollout.samples")
    return [*models(read_trained(runs, data_sets), about), costs(most, read_took(runs, most), samples)]
