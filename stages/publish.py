"""Door `publish`: the published tables from the runs that `python -m flows tables` made; a stage of no dvc.yaml.

argv: folder of runs (<data set>/<training seed>-<sampling seed>, and <data set>/t<temperature>, each a workspace whose
reports/metrics hold what was measured), folder to write: scenario_quality.json (see `results.rows`); every table as Markdown,
its picture as SVG; README.md; provenance.json.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.methods import Method, read_methods
from drivegen.core.seeds import rng
from drivegen.report.published import results
from drivegen.report.published.all_tables import PooledSets, models_and_costs, tables_of, trainings, transfers
from drivegen.report.published.files import write_published
from drivegen.report.published.results import DataSet, Pooled
from drivegen.report.published.runs import read_data_set
from drivegen.report.table import Table
from drivegen.warehouse.provenance import describe_runs
from stages._door import require


@dataclass(frozen=True)
class About:
    """A data set of `tables.quality.data`.

    Attributes:
        title: in words. folder: below the folder of real recordings, "" where none is needed.
        params: what differs from params.yaml. folders: the same for values that name the folder (FOLDER stands for it).
        front: whether DriveGen is run at every temperature. by_scene: too few scenes to average.
    """

    title: str
    folder: str
    params: dict[str, Any]
    folders: dict[str, Any]
    front: bool
    by_scene: bool


SECTION = "tables.quality"


@dataclass(frozen=True)
class Params:
    """Section `tables.quality`.

    Attributes:
        draws: bootstrap draws. seeds, sampling_seeds: of training and of the futures, every pair a run. temperatures: of the
            front of error and diversity. params: what differs from params.yaml in every run. data: in the order of the tables.
        transfer: pairs of data sets whose order of methods is compared. training: pairs of the same scenes, by models that learnt
            from less and from more. own, rivals, baselines, selectors: of `run`, the order of rows.
    """

    seed: int
    own: tuple[str, ...]
    rivals: tuple[str, ...]
    baselines: tuple[str, ...]
    selectors: tuple[str, ...]
    draws: int
    seeds: tuple[int, ...]
    sampling_seeds: tuple[int, ...]
    temperatures: tuple[float, ...]
    params: dict[str, Any]
    data: dict[str, About]
    transfer: tuple[tuple[str, ...], ...]
    training: tuple[tuple[str, ...], ...]

    @property
    def methods(self) -> dict[str, Method]:
        """Every generator in the order of the tables."""
        return read_methods([*self.own, *self.rivals, *self.baselines])

    @property
    def runs(self) -> Iterator[str]:
        """The folder of every run that tables are made from."""
        pairs = results.pairs(self.seeds, self.sampling_seeds)
        yield from (f"{name}/{pair.folder}" for name in self.data for pair in pairs)
        yield from (f"{name}/t{t}" for name, about in self.data.items() if about.front for t in self.temperatures)


def main(params: Params, runs: Path, out: Path) -> None:
    """Read every run, pool, write."""
    require(runs, "run `make tables`, which makes the runs and then calls this")
    pooled_sets = _pool(params, runs)
    rows = [row for data, pooled in pooled_sets.values() for row in results.rows(data, pooled)]
    if not rows:
        raise UnusableInput(f"{runs} holds no run that was evaluated: run `make tables`", reason="no-runs")
    tables = _tables(params, runs, pooled_sets)
    titles = {name: data.title for name, (data, _) in pooled_sets.items()}
    provenance = {"seed": params.seed, "bootstrap_draws": params.draws, **describe_runs(runs, params.runs)}
    write_published(out, rows, tables, titles, provenance)
    missing = [name for name in params.data if name not in pooled_sets] or ["none"]
    print(f"publish: {len(rows)} figures of {', '.join(pooled_sets)}; not measured: {', '.join(missing)}")


def _pool(params: Params, runs: Path) -> PooledSets:
    """Every data set that was run, pooled."""
    pooled_sets, pairs = dict[str, tuple[DataSet, Pooled]](), results.pairs(params.seeds, params.sampling_seeds)
    for name, about in params.data.items():
        data = read_data_set(runs / name, about.title, pairs, params.methods, by_scene=about.by_scene)
        if data is not None:
            pooled_sets[name] = (data, results.pool(data, params.draws, rng(params.seed, "publish", name)))
    return pooled_sets


def _tables(params: Params, runs: Path, pooled_sets: PooledSets) -> list[Table]:
    """The tables of each data set, then those over several."""
    selectors, tables = plugins.names("selectors", params.selectors), []
    for name, (data, pooled) in pooled_sets.items():
        temperatures = params.temperatures if params.data[name].front else ()
        tables += tables_of(data, pooled, runs / name, temperatures, selectors, params.draws, params.seed)
    tables += transfers(pooled_sets, params.transfer)
    tables += trainings(pooled_sets, params.training, params.draws, params.seed)
    return [*tables, *models_and_costs(pooled_sets, runs, params.methods)]
