"""The door `publish_corner`: tables III and IV, extended, from the runs of `make tables PART=corner`. It is in no dvc.yaml.

argv: folder of runs (one a seed, each a workspace), the folder of published tables (gets corner_cases.json, a table of outcomes
and one of costs for each driver; mutation_score.json, its table and chart where all runs have a score; repair.json and its tables
of drivers that all runs have repaired; the index corner.md, provenance-corner.json).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson
import pyarrow.parquet as pq

from drivegen.core.errors import MissingTool
from drivegen.report.published_corner import Attacks, Costs, corner_rows
from drivegen.report.published_files import write_part
from drivegen.report.published_mutation import mutation_rows, mutation_table
from drivegen.report.published_repair import pooled_rows, repair_tables
from drivegen.report.sections.attack import cost_table, outcome_table
from drivegen.report.table import Table
from drivegen.store.files import write_json
from drivegen.warehouse.provenance import describe_runs
from stages._door import COST_FOLDER, enter

DATA = "sumo_corpus"
SCORE = Path("reports/pieces/mutation_score.json")
REPAIRED = Path("reports/pieces/repair")


@dataclass(frozen=True)
class Params:
    """`seeds` and `params`: the runs, which the flow `tables` reads."""

    seed: int
    seeds: list[int]
    params: dict[str, Any]


def main(params: Params, runs: Path, published: Path) -> None:
    """Rows of all drivers; tables of the first seed."""
    roots = [runs / str(seed) for seed in params.seeds]
    drivers = sorted(file.stem for file in (roots[0] / "reports/metrics/attack").glob("*.json"))
    if not drivers:
        raise MissingTool(f"{roots[0]} holds no attacks: run `make tables PART=corner`")
    rows: list[dict[str, Any]] = []
    tables: list[Table] = []
    for driver in drivers:
        of_runs = [_read(root, driver) for root in roots]
        rows += corner_rows(DATA, driver, of_runs)
        attacks, took = of_runs[0]
        costs = {f"attack/{driver}-{key}": cost for key, cost in took.items()}
        tables += [outcome_table(driver, attacks), cost_table(driver, attacks, costs)]
    write_json(published / "corner_cases.json", rows)
    if all((root / SCORE).exists() for root in roots):
        scores = [orjson.loads((root / SCORE).read_bytes()) for root in roots]
        write_json(published / "mutation_score.json", list(mutation_rows(DATA, scores)))
        tables.append(mutation_table(scores[0]))
    if repaired := {driver: list(pooled_rows(DATA, driver, of_runs)) for driver, of_runs in _repaired(roots)}:
        write_json(published / "repair.json", [row for own in repaired.values() for row in own])
        tables += [table for driver, own in repaired.items() for table in repair_tables(driver, own)]
    provenance = {"seed": params.seed, **describe_runs(runs, map(str, params.seeds))}
    write_part(published, "corner", "Corner cases: SUMO corpus (simulated)", tables, provenance)


def _repaired(roots: list[Path]) -> Iterator[tuple[str, list[Any]]]:
    """Drivers that every run has repaired, with the rows of each run."""
    for file in sorted((roots[0] / REPAIRED).glob("*.json")):
        files = [root / REPAIRED / file.name for root in roots]
        if all(each.exists() for each in files):
            yield file.stem, [orjson.loads(each.read_bytes()) for each in files]


def _read(root: Path, driver: str) -> tuple[Attacks, Costs]:
    """What the attacks of a run came to, and took."""
    attacks = orjson.loads((root / "reports/metrics/attack" / f"{driver}.json").read_bytes())
    files = {key: root / COST_FOLDER / f"attack-{driver}-{key}.parquet" for key in attacks}
    tables = {key: pq.read_table(file).to_pylist() for key, file in files.items() if file.exists()}
    return attacks, {key: {line["name"]: line["value"] for line in lines} for key, lines in tables.items()}


if __name__ == "__main__":
    enter("publish_corner", Params, main)
