"""The door `publish_corner`: tables III and IV, extended, from the runs of `make tables PART=corner`. It is in no dvc.yaml.

argv: folder of runs (one a seed, each a workspace), the folder of published tables (gets corner_cases.json, a table of outcomes
and one of costs for each driver, lead.json and its table; where all runs have them, beset.json, mutation_score.json,
naturalness.json, recall.json, repair.json, survival.json and transfer.json with theirs; the index corner.md,
provenance-corner.json).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson
import pyarrow.parquet as pq

from drivegen.core.errors import MissingTool
from drivegen.core.settings import Count
from drivegen.report.published.beset import beset_table
from drivegen.report.published.corner import Attacks, Costs, corner_rows
from drivegen.report.published.files import write_part
from drivegen.report.published.lead import METRICS as LED
from drivegen.report.published.lead import lead_rows, lead_table
from drivegen.report.published.mutation import mutation_rows, mutation_table
from drivegen.report.published.naturalness import naturalness_table
from drivegen.report.published.recall import ablation_table, recall_table
from drivegen.report.published.repair import repair_tables
from drivegen.report.published.seeds import over_seeds
from drivegen.report.published.survival import survival_table
from drivegen.report.published.transfer import transfer_table
from drivegen.report.sections.attack import cost_table, outcome_table, proposer_tables
from drivegen.report.table import Table
from drivegen.store.files import write_json
from drivegen.store.results import read_values
from drivegen.warehouse.provenance import describe_runs
from stages._door import COST_FOLDER

DATA = "sumo_corpus"
SCORE = Path("reports/pieces/mutation_score.json")
TRANSFERRED = Path("reports/pieces/transfer.json")
NATURAL = Path("reports/pieces/naturalness.json")
FOUND = Path("reports/pieces/recall.json")
HELD = Path("reports/pieces/survival.json")
BESET = Path("reports/pieces/beset.json")
PIECES = {
    FOUND: (recall_table, ablation_table),
    BESET: (beset_table,),
    TRANSFERRED: (transfer_table,),
    NATURAL: (naturalness_table,),
    HELD: (survival_table,),
}
"""Files of rows that every run has measured or none, and the tables of each."""

REPAIRED = Path("reports/pieces/repair")


SECTION = "tables.corner"


@dataclass(frozen=True)
class Params:
    """`seeds` and `params`: the runs, which the flow `tables` reads. `draws`: of the bootstrap where two attacks are compared."""

    seed: int
    seeds: list[int]
    params: dict[str, Any]
    draws: Count


def main(params: Params, runs: Path, published: Path) -> None:
    """Rows of all drivers; tables of the first seed."""
    roots = [runs / str(seed) for seed in params.seeds]
    drivers = sorted(file.stem for file in (roots[0] / "reports/metrics/attack").glob("*.json"))
    if not drivers:
        raise MissingTool(f"{roots[0]} holds no attacks: run `make tables PART=corner`")
    rows, leads = list[dict[str, Any]](), list[dict[str, Any]]()
    tables: list[Table] = []
    for driver in drivers:
        of_runs = [_read(root, driver) for root in roots]
        rows += corner_rows(DATA, driver, of_runs)
        values = read_values(roots[0] / "reports/metrics/attack" / f"{driver}.parquet", LED)
        leads += lead_rows(driver, values, params.draws, params.seed)
        attacks, took = of_runs[0]
        costs = {f"attack/{driver}-{key}": cost for key, cost in took.items()}
        tables += [outcome_table(driver, attacks), *proposer_tables(driver, attacks), cost_table(driver, attacks, costs)]
    write_json(published / "corner_cases.json", rows)
    if leads:
        write_json(published / "lead.json", leads)
        tables.append(lead_table(leads))
    if scores := _of_all(roots, SCORE):
        write_json(published / "mutation_score.json", list(mutation_rows(DATA, scores)))
        tables.append(mutation_table(scores[0]))
    for piece, tables_of in PIECES.items():
        if (of_runs := _of_all(roots, piece)) and (means := list(over_seeds(DATA, of_runs))):
            write_json(published / piece.name, means)
            tables += [table(means) for table in tables_of]
    repaired = {file.stem: _of_all(roots, REPAIRED / file.name) for file in sorted((roots[0] / REPAIRED).glob("*.json"))}
    means_of = {driver: list(over_seeds(DATA, of_runs)) for driver, of_runs in repaired.items() if of_runs}
    if means_of:
        write_json(published / "repair.json", [{"driver": driver, **line} for driver, own in means_of.items() for line in own])
        tables += [table for driver, own in means_of.items() for table in repair_tables(driver, own)]
    provenance = {"seed": params.seed, **describe_runs(runs, map(str, params.seeds))}
    write_part(published, "corner", "Corner cases: SUMO corpus (simulated)", tables, provenance)


def _of_all(roots: list[Path], piece: Path) -> list[Any]:
    """What each run has measured in a file; empty where one has not."""
    files = [root / piece for root in roots]
    return [orjson.loads(file.read_bytes()) for file in files] if all(file.exists() for file in files) else []


def _read(root: Path, driver: str) -> tuple[Attacks, Costs]:
    """What the attacks of a run came to, and took."""
    attacks = orjson.loads((root / "reports/metrics/attack" / f"{driver}.json").read_bytes())
    files = {key: root / COST_FOLDER / f"attack-{driver}-{key}.parquet" for key in attacks}
    tables = {key: pq.read_table(file).to_pylist() for key, file in files.items() if file.exists()}
    return attacks, {key: {line["name"]: line["value"] for line in lines} for key, lines in tables.items()}
