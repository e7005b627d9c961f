"""The door `publish_rates`: how often drivers fail, from the runs of `make tables PART=rates`. It is in no dvc.yaml.

argv: folder of runs (one a seed, each a workspace), the folder of published tables (gets rates.json, a table of the first seed,
the index rates.md, provenance-rates.json).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from drivegen.report.published.files import write_part
from drivegen.report.published.rates import rate_rows, rate_table
from drivegen.store.files import write_json
from drivegen.warehouse.provenance import describe_runs
from stages._door import require

DATA = "sumo_corpus"
RATES = Path("reports/pieces/rates.json")


SECTION = "tables.rates"


@dataclass(frozen=True)
class Params:
    """`seeds` and `params`: the runs, which the flow `tables` reads."""

    seed: int
    seeds: list[int]
    params: dict[str, Any]


def main(params: Params, runs: Path, published: Path) -> None:
    """Means over seeds; the table is of the first."""
    files = [require(runs / str(seed) / RATES, "run `make tables PART=rates`") for seed in params.seeds]
    rates = [orjson.loads(file.read_bytes()) for file in files]
    write_json(published / "rates.json", list(rate_rows(DATA, rates)))
    provenance = {"seed": params.seed, **describe_runs(runs, map(str, params.seeds), [RATES])}
    write_part(published, "rates", "Rates of failure: SUMO corpus (simulated)", [rate_table(rates[0])], provenance)
