"""Stage `assets`: collect the vehicles of the training logs in a table, and how closely they follow one another in another.

argv: scenarios (a folder with train/), the table of vehicles (Parquet), the table of gaps (Parquet).
"""

from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from drivegen.core.settings import Count
from drivegen.placement.gaps import measure_gaps
from drivegen.placement.table import build_table
from drivegen.store.assets import write_assets
from drivegen.store.scenarios import read_shard, shards
from stages._door import require


@dataclass(frozen=True)
class Params:
    """Section `assets`: gaps are measured in about `gap_scenarios` scenes, the first ones of every shard."""

    gap_scenarios: Count


def main(params: Params, scenarios: Path, out: Path, gaps: Path) -> None:
    """Read the train split only: what is measured on the test split is placed on no other map."""
    files = shards(require(scenarios / "train", "run the ingest stage"))
    table = build_table(scenario for shard in files for scenario in read_shard(shard))
    write_assets(out, table.to_arrow())
    of_each = -(-params.gap_scenarios // max(len(files), 1))
    rows = measure_gaps(scenario for shard in files for scenario in islice(read_shard(shard), of_each))
    write_assets(gaps, rows.to_arrow())
    led = int(rows.led.sum())
    print(f"assets: {len(table)} different vehicles, {int(table.count.sum())} tracks; gaps of {len(rows)}, {led} with a leader")
