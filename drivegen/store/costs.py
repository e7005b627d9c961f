"""What a stage took: times and memory, which differ from run to run.

They are kept apart from results, out of everything that promises the same bytes for the same seed. This is a module of its
own because every stage needs it, and DVC runs a stage again when a module that it needs has changed.
"""

from collections.abc import Mapping
from pathlib import Path

import pyarrow as pa

from drivegen.store.files import write_table

COST = pa.schema([("stage", pa.string()), ("item", pa.string()), ("name", pa.string()), ("value", pa.float64())])
"""Columns of a cost: stage, item (method, driver, ...), what was measured with its unit (cpu_seconds, ...)."""


def write_cost(folder: Path, stage: str, item: str, costs: Mapping[str, float]) -> None:
    """What a stage took, as `folder/<stage>-<item>.parquet`: {"cpu_seconds": 3.1, "scenarios": 120}."""
    names = sorted(costs)
    columns = ([stage] * len(names), [item] * len(names), names, [float(costs[name]) for name in names])
    table = pa.table({field.name: pa.array(column, field.type) for field, column in zip(COST, columns, strict=True)})
    write_table(folder / (f"{stage}-{item}.parquet" if item else f"{stage}.parquet"), table)
