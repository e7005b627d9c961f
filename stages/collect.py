"""Stage collect: all result and cost parts in one DuckDB file with views (a leaf: nothing depends on it).

argv: folder of result parts, folder of cost parts, the DuckDB file to write.
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen.store.costs import COST
from drivegen.store.results import RESULT
from drivegen.store.warehouse import build, read_parts, result_parts
from stages._door import enter, require


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


def main(params: Params, results: Path, costs: Path, out: Path) -> dict[str, float]:  # noqa: ARG001  # every main takes params
    """Collect the parts below `results` and `costs` (which may be absent: a fresh checkout has no times)."""
    parts = result_parts(require(results, "run the stages that measure"))
    table = read_parts(parts, RESULT)
    build(out, table, read_parts(sorted(costs.glob("*.parquet")), COST))
    print(f"{out}: {table.num_rows} results of {len(parts)} parts")
    return {"results": float(table.num_rows)}


if __name__ == "__main__":
    enter("collect", Params, main)
