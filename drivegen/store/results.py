"""Results as long rows: one number of one scenario or of one sample of it a row, in Parquet parts that DuckDB reads together.

Times are no results: they differ from run to run and are kept by `costs.py`.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import orjson
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from drivegen.store.files import whole

RESULT = pa.schema(
    [
        ("run", pa.string()),
        ("stage", pa.string()),
        ("item", pa.string()),
        ("method", pa.string()),
        ("driver", pa.string()),
        ("scenario", pa.string()),
        ("sample", pa.int16()),
        ("metric", pa.string()),
        ("value", pa.float64()),
        ("seed", pa.int64()),
        ("backend", pa.string()),
        ("inputs", pa.string()),
    ]
)
"""Columns of a result. `driver` and `method` are "" where there is none; `sample` is WHOLE_SCENE for all futures together."""

WHOLE_SCENE = -1
"""The sample of a number that is of a scene as a whole, often the mean over its samples."""

ROW_GROUP = 2**20
"""Rows that are written at once."""


@dataclass(frozen=True)
class Run:
    """Who measured: the columns that all rows of a part share.

    Attributes:
        run: hash of stage, item, settings and inputs, from `run_id`.
        stage: the stage's word. method, driver: what was measured, "" where there is none.
        seed: the pipeline's seed.
        backend: what chose or simulated, e.g. "batch", "sumo" or "learned"; "" where there is no choice.
        item: the stage's item, as costs name it: a method, a driver, the number of a round. inputs: what was read, paths.
    """

    run: str
    stage: str
    method: str
    driver: str
    seed: int
    backend: str
    item: str = ""
    inputs: str = ""

    @classmethod
    def of(
        cls,
        stage: str,
        item: str,
        settings: Mapping[str, Any],
        inputs: Sequence[Path],
        *,
        method: str = "",
        driver: str = "",
        backend: str = "",
    ) -> Self:
        """The run of a stage's item with `settings`, its seed among them, that read `inputs`."""
        run, read = run_id({"stage": stage, "item": item, **settings}, inputs), " ".join(map(str, inputs))
        return cls(run, stage, method, driver, settings["seed"], backend, item, read)


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


def result_rows(
    run: Run,
    scenarios: Sequence[str],
    metrics: Mapping[str, NDArray[np.floating]],
    samples: NDArray[np.integer] | None = None,
) -> pa.Table:
    """Long rows of `metrics`, each (S,); NaN is kept out, for it is no measurement.

    They are of S scenarios, or with `samples` (S,) of that sample of each.
    """
    names, count = sorted(metrics), len(scenarios)
    value = np.concatenate([np.asarray(metrics[name], np.float64) for name in names]) if names else np.zeros(0)
    columns = {
        "scenario": np.tile(np.asarray(scenarios, object), len(names)),
        "sample": np.tile(np.full(count, WHOLE_SCENE) if samples is None else samples, len(names)),
        "metric": np.repeat(np.asarray(names, object), count),
        "value": value,
    }
    shared = {name: [text] * len(value) for name, text in asdict(run).items()}
    table = pa.table({field.name: pa.array((columns | shared)[field.name], field.type) for field in RESULT})
    return table.filter(pa.array(np.isfinite(value)))


def record_rows(run: Run, records: Mapping[str, Mapping[str, object]], sample: int = WHOLE_SCENE) -> pa.Table:
    """Long rows of `records` by scenario, each with metrics by name: what is no number or truth value is left out."""
    metrics = sorted({name for record in records.values() for name in record})
    values = {name: np.array([_number(record.get(name)) for record in records.values()]) for name in metrics}
    return result_rows(run, list(records), values, np.full(len(records), sample))


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else np.nan


def write_results(path: Path, parts: Iterable[pa.Table]) -> None:
    """All rows of one stage's item as one Parquet part; no more than a row group of them is in memory."""
    waiting, rows = [RESULT.empty_table()], 0
    with (
        whole(path) as temporary,
        pq.ParquetWriter(temporary, RESULT, compression="zstd", compression_level=3) as writer,
    ):
        for part in parts:
            waiting, rows = [*waiting, part], rows + len(part)
            while rows > ROW_GROUP:
                table = pa.concat_tables(waiting)
                writer.write_table(table.slice(0, ROW_GROUP), ROW_GROUP)
                waiting, rows = [table.slice(ROW_GROUP)], rows - ROW_GROUP
        writer.write_table(pa.concat_tables(waiting), ROW_GROUP)


def read_values(path: Path, metrics: Sequence[str]) -> dict[str, dict[str, dict[str, float]]]:
    """Of the rows of whole scenarios: the value by item, metric (of `metrics`) and scenario; nothing where there is no file."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    if path.exists():
        wanted = [("metric", "in", list(metrics)), ("sample", "=", WHOLE_SCENE)]
        for row in pq.read_table(path, columns=["item", "metric", "scenario", "value"], filters=wanted).to_pylist():
            found.setdefault(row["item"], {}).setdefault(row["metric"], {})[row["scenario"]] = row["value"]
    return found
