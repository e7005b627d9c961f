"""Results as long rows: one number of one scenario a row, in Parquet parts that DuckDB reads together.

Times are no results: they differ from run to run and are kept by `costs.py`.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import orjson
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.store.files import write_table

RESULT = pa.schema(
    [
        ("run", pa.string()),
        ("stage", pa.string()),
        ("method", pa.string()),
        ("driver", pa.string()),
        ("scenario", pa.string()),
        ("metric", pa.string()),
        ("value", pa.float64()),
        ("seed", pa.int64()),
        ("backend", pa.string()),
    ]
)
"""Columns of a result. `driver` and `method` are "" where there is none; `scenario` is "" for a whole set."""


@dataclass(frozen=True)
class Run:
    """Who measured: the columns that all rows of a part share.

    Attributes:
        run: hash of the inputs, from `run_id`.
        stage: the stage's word. method, driver: what was measured, "" where there is none.
        seed: the pipeline's seed.
        backend: what chose or simulated, e.g. "batch", "sumo" or "learned"; "" where there is no choice.
    """

    run: str
    stage: str
    method: str
    driver: str
    seed: int
    backend: str


def run_id(settings: Mapping[str, object], inputs: Sequence[Path]) -> str:
    """Twelve hex digits over settings and the bytes of the input files (folders: all files below, by relative name).

    The setting `workers` is left out: results do not depend on it.
    """
    named = {name: value for name, value in settings.items() if name != "workers"}
    digest = hashlib.sha256(orjson.dumps(named, option=orjson.OPT_SORT_KEYS | orjson.OPT_NON_STR_KEYS))
    for place in inputs:
        files = sorted(p for p in place.rglob("*") if p.is_file()) if place.is_dir() else [place]
        for file in files:
            digest.update(str(file.relative_to(place)).encode() + b"\x00")
            digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()[:12]


def result_rows(run: Run, scenarios: Sequence[str], metrics: Mapping[str, NDArray[np.floating]]) -> pa.Table:
    """Long rows of `metrics`, each (S,) over the S scenarios; NaN is kept out, for it is no measurement."""
    names = sorted(metrics)
    value = np.concatenate([np.asarray(metrics[name], np.float64) for name in names]) if names else np.zeros(0)
    columns = {
        "scenario": np.tile(np.asarray(scenarios, object), len(names)),
        "metric": np.repeat(np.asarray(names, object), len(scenarios)),
        "value": value,
    }
    shared = {name: [getattr(run, name)] * len(value) for name in ("run", "stage", "method", "driver", "seed", "backend")}
    table = pa.table({field.name: pa.array((columns | shared)[field.name], field.type) for field in RESULT})
    return table.filter(pa.array(np.isfinite(value)))


def write_results(path: Path, parts: Sequence[pa.Table]) -> None:
    """All rows of one stage's item as one Parquet part."""
    write_table(path, pa.concat_tables([RESULT.empty_table(), *parts]))
