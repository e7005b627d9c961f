"""The door `publish_drivers`: tables of drivers, read from the runs of `make tables PART=drivers`. It is in no dvc.yaml.

argv: folder of runs (one a data set, each a workspace), the folder of published tables (gets drivers.json,
ranking.json and drivers-<table>.md).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from drivegen.core.methods import read_methods
from drivegen.core.settings import Count
from drivegen.report.published_drivers import driver_rows, driver_tables, read_tests
from drivegen.report.published_ranking import kinds_of, ranking_rows, ranking_table
from drivegen.store.files import whole, write_json
from drivegen.store.results import RESULT
from drivegen.warehouse.database import read_parts
from stages._door import enter, require

PIECES = Path("reports/pieces")
RANK, TUNED = PIECES / "rank.parquet", PIECES / "drive_tuned.parquet"


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws; `params` and `data`: the runs, which the flow `tables` reads."""

    seed: int
    draws: Count
    params: dict[str, Any]
    data: dict[str, Any]


def main(params: Params, runs: Path, published: Path) -> None:
    """Two JSON files, and one Markdown file a table; data sets that were not run are left out."""
    folders = {name: require(runs, "run `make tables PART=drivers`") / name for name in params.data}
    kinds = [
        k for name, run in folders.items() if (run / RANK).exists() for k in kinds_of(name, read_parts([run / RANK], RESULT))
    ]
    ranking = list(ranking_rows(kinds, params.draws, params.seed))
    tuned = [row for name, run in folders.items() if (run / TUNED).exists() for row in _tuned(name, run / TUNED, params)]
    write_json(published / "ranking.json", ranking)
    write_json(published / "drivers.json", tuned)
    titles = {name: method.title for name, method in read_methods().items()}
    for table in (ranking_table(ranking, titles), *driver_tables(tuned)):
        with whole(published / f"{table.name}.md") as temporary:
            temporary.write_text(table.markdown(), encoding="utf-8")


def _tuned(name: str, results: Path, params: Params) -> list[dict[str, Any]]:
    diversity = orjson.loads(results.with_suffix(".json").read_bytes())
    tests = read_tests(name, params.data[name]["protocol"], read_parts([results], RESULT), diversity)
    return list(driver_rows(tests, params.draws, params.seed))


if __name__ == "__main__":
    enter("publish_drivers", Params, main)
