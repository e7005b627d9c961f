"""The door `publish_corner`: tables III and IV, extended, from the runs of `make tables PART=corner`. It is in no dvc.yaml.

argv: folder of runs (one a seed, each a workspace), the folder of published tables (gets corner_cases.json, corner-<driver>.md
and corner-<driver>-costs.md; mutation_score.json, mutation-score.md and its chart where all runs have a score).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson
import pyarrow.parquet as pq

from drivegen.core.errors import MissingTool
from drivegen.report.published_corner import Attacks, Costs, corner_rows
from drivegen.report.published_mutation import mutation_rows, mutation_table
from drivegen.report.sections.attack import cost_table, outcome_table
from drivegen.store.files import whole, write_json
from stages._door import COST_FOLDER, enter

DATA = "sumo_corpus"
SCORE = Path("reports/pieces/mutation_score.json")


@dataclass(frozen=True)
class Params:
    """`seeds` and `params`: the runs, which the flow `tables` reads."""

    seeds: list[int]
    params: dict[str, Any]


def main(params: Params, runs: Path, published: Path) -> None:
    """Rows of all drivers; tables of the first seed."""
    roots = [runs / str(seed) for seed in params.seeds]
    drivers = sorted(file.stem for file in (roots[0] / "reports/metrics/attack").glob("*.json"))
    if not drivers:
        raise MissingTool(f"{roots[0]} holds no attacks: run `make tables PART=corner`")
    rows: list[dict[str, Any]] = []
    for driver in drivers:
        of_runs = [_read(root, driver) for root in roots]
        rows += corner_rows(DATA, driver, of_runs)
        costs = {f"attack/{driver}-{key}": cost for key, cost in of_runs[0][1].items()}
        for table, name in ((outcome_table(driver, of_runs[0][0]), ""), (cost_table(driver, of_runs[0][0], costs), "-costs")):
            with whole(published / f"corner-{driver}{name}.md") as temporary:
                temporary.write_text(table.markdown(), encoding="utf-8")
    write_json(published / "corner_cases.json", rows)
    if all((root / SCORE).exists() for root in roots):
        _publish_score([orjson.loads((root / SCORE).read_bytes()) for root in roots], published)


def _publish_score(scores: list[dict[str, Any]], published: Path) -> None:
    write_json(published / "mutation_score.json", list(mutation_rows(DATA, scores)))
    table = mutation_table(scores[0])
    for name, content in ((f"{table.name}.md", table.markdown().encode()), (f"{table.name}.svg", table.picture)):
        with whole(published / name) as temporary:
            temporary.write_bytes(content)


def _read(root: Path, driver: str) -> tuple[Attacks, Costs]:
    """What the attacks of a run came to, and took."""
    attacks = orjson.loads((root / "reports/metrics/attack" / f"{driver}.json").read_bytes())
    files = {key: root / COST_FOLDER / f"attack-{driver}-{key}.parquet" for key in attacks}
    tables = {key: pq.read_table(file).to_pylist() for key, file in files.items() if file.exists()}
    return attacks, {key: {line["name"]: line["value"] for line in lines} for key, lines in tables.items()}


if __name__ == "__main__":
    enter("publish_corner", Params, main)
