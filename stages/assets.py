"""Stage `assets`: collect the vehicles of the training logs in a table.

argv: scenarios (a folder with train/), the table (Parquet).
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen.assets.table import build_table
from drivegen.store.assets import write_assets
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, require


@dataclass(frozen=True)
class Params:
    """Section `assets`: nothing to choose yet."""


def main(params: Params, scenarios: Path, out: Path) -> None:  # noqa: ARG001 - every stage takes its section
    """Read the train split only: what is measured on the test split is placed on no other map."""
    found = shards(require(scenarios / "train", "run the ingest stage"))
    table = build_table(scenario for shard in found for scenario in read_shard(shard))
    write_assets(out, table.to_arrow())
    print(f"assets: {len(table)} different vehicles, {int(table.count.sum())} tracks")


if __name__ == "__main__":
    enter("assets", Params, main)
