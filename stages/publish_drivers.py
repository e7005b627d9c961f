"""The door `publish_drivers`: tables of drivers, read from the runs of `make tables PART=drivers`. It is in no dvc.yaml.

argv: folder of runs (one a data set, each a workspace), the folder of published tables (gets drivers.json, ranking.json,
drivers-<table>.md with charts where there are any, their index drivers.md, provenance-drivers.json).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from drivegen.core.methods import read_methods
from drivegen.core.settings import Count
from drivegen.drivers.mutants.table import MUTATIONS
from drivegen.report.published.amounts import amount_tables
from drivegen.report.published.drivers import driver_tables
from drivegen.report.published.files import write_part
from drivegen.report.published.ranking import kinds_of, ranking_rows, ranking_table
from drivegen.report.published.tuned import Tests, driver_rows, read_tests
from drivegen.store.files import write_json
from drivegen.store.results import RESULT
from drivegen.warehouse.database import read_parts
from drivegen.warehouse.provenance import describe_runs
from drivegen.warehouse.runs import PIECES
from stages._door import require

EQUIVALENT = [name for name, mutation in MUTATIONS.items() if not mutation.fails]
"""Drivers that do as another does: ranked beside it they would count twice."""

RANK, TUNED = PIECES / "rank.parquet", PIECES / "drive_tuned.parquet"


SECTION = "tables.drivers"


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws; `params` and `data`: the runs, which the flow `tables` reads."""

    seed: int
    draws: Count
    params: dict[str, Any]
    data: dict[str, Any]


def main(params: Params, runs: Path, published: Path) -> None:
    """Two JSON files, tables, their index and provenance; of data sets that were not run only that they are missing."""
    folders = {name: require(runs, "run `make tables PART=drivers`") / name for name in params.data}
    kinds = [
        kind
        for name, run in folders.items()
        if (run / RANK).exists()
        for kind in kinds_of(name, read_parts([run / RANK], RESULT), EQUIVALENT)
    ]
    ranking = list(ranking_rows(kinds, params.draws, params.seed))
    tests = [_read(name, run / TUNED, params) for name, run in folders.items() if (run / TUNED).exists()]
    tuned = [row for one in tests for row in driver_rows(one, params.draws, params.seed)]
    write_json(published / "ranking.json", ranking)
    write_json(published / "drivers.json", tuned)
    titles = {name: method.title for name, method in read_methods().items()}
    about = {one.data: (str(params.data[one.data]["title"]), len(set(one.recordings))) for one in tests}
    tables = [ranking_table(ranking, titles), *driver_tables(tuned, about), *amount_tables(tuned, about)]
    provenance = {"seed": params.seed, "bootstrap_draws": params.draws, **describe_runs(runs, folders, (RANK, TUNED))}
    write_part(published, "drivers", "Drivers: ranked by traffic, and tuned on it", tables, provenance)


def _read(name: str, results: Path, params: Params) -> Tests:
    diversity = orjson.loads(results.with_suffix(".json").read_bytes())
    return read_tests(name, params.data[name]["protocol"], read_parts([results], RESULT), diversity)
