"""What leads from a result to where it lies: tables of scenarios, of samples, of recordings and of parameters.

They are read from what the stages wrote, the small columns of shards alone: no motion, no map.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import recording
from drivegen.store.scenarios import shards

SCENARIOS = pa.schema(
    [
        ("scenario", pa.string()),
        ("split", pa.string()),
        ("source", pa.string()),
        ("city", pa.string()),
        ("log", pa.string()),
        ("shard", pa.string()),
        ("vehicles", pa.int16()),
        ("steps", pa.int16()),
    ]
)
"""Every scenario: `split` is its folder's name, `log` the recording that it was cut from, `shard` the file that it is in."""

SAMPLES = pa.schema(
    [
        ("stage", pa.string()),
        ("item", pa.string()),
        ("method", pa.string()),
        ("scenario", pa.string()),
        ("sample", pa.int16()),
        ("shard", pa.string()),
        ("vehicles", pa.int16()),
        ("illegal", pa.int16()),
        ("dropped", pa.int16()),
        ("left_map", pa.int16()),
    ]
)
"""Every future: the stage and the item that made it, the file that it is in, its vehicles, and how many of them are illegal, were
left out, have left the map."""

RECORDINGS = pa.schema(
    [
        ("stage", pa.string()),
        ("item", pa.string()),
        ("scenario", pa.string()),
        ("sample", pa.int16()),
        ("href", pa.string()),
        ("text", pa.string()),
    ]
)
"""Every recording: of which sample, the file below `reports`, what it shows. One of all methods has no stage and no item."""

PARAMETERS = pa.schema([("stage", pa.string()), ("name", pa.string()), ("value", pa.string())])
"""Every number of params.yaml: its section, its dotted name there, its value as text (JSON where it is no word)."""


def read_scenarios(folders: Mapping[str, Path]) -> pa.Table:
    """A row of every scenario in the shards of `folders`, by split; folders that are not there hold none."""
    parts = [_scenarios(split, shard) for split, folder in folders.items() for shard in shards(folder)]
    return pa.concat_tables([SCENARIOS.empty_table(), *parts])


def _scenarios(split: str, shard: Path) -> pa.Table:
    found = _columns(shard, ["scenario_id", "source", "city", "horizon", "vehicles.kind"])
    ids = found["scenario_id"].to_pylist()
    columns = {
        "scenario": ids,
        "split": [split] * len(ids),
        "source": found["source"],
        "city": found["city"],
        "log": [recording(scenario) for scenario in ids],
        "shard": [str(shard)] * len(ids),
        "vehicles": [len(kinds) for kinds in found["vehicles.kind"].to_pylist()],
        "steps": np.asarray(found["horizon"]) + 1,
    }
    return _table(columns, SCENARIOS)


def read_sample_table(stage: str, item: str, folder: Path) -> pa.Table:
    """A row of every future in the shards of `folder`, which `item` of `stage` made; none where there is no such folder."""
    return pa.concat_tables([SAMPLES.empty_table(), *(_samples(stage, item, shard) for shard in shards(folder))])


def _samples(stage: str, item: str, shard: Path) -> pa.Table:
    found = _columns(shard, ["scenario_id", "method", "samples", "vehicles", "violation", "dropped", "left_map"])
    counts, vehicles = np.asarray(found["samples"]), np.asarray(found["vehicles"])
    each = np.repeat(np.arange(len(counts)), counts)
    sample = np.arange(len(each)) - np.repeat(np.cumsum(counts) - counts, counts)
    of_sample = np.repeat(np.arange(len(each)), vehicles[each])  # of every vehicle, as flags lie end to end

    def flagged(name: str) -> np.ndarray[Any, Any]:
        flags = found[name].combine_chunks().flatten().to_numpy(zero_copy_only=False) > 0
        return np.bincount(of_sample, flags, len(each)).astype(np.int16)

    columns = {
        "stage": [stage] * len(each),
        "item": [item] * len(each),
        "method": found["method"].take(each),
        "scenario": found["scenario_id"].take(each),
        "sample": sample,
        "shard": [str(shard)] * len(each),
        "vehicles": vehicles[each],
        **{to: flagged(name) for to, name in (("illegal", "violation"), ("dropped", "dropped"), ("left_map", "left_map"))},
    }
    return _table(columns, SAMPLES)


def read_recordings(listing: Path) -> pa.Table:
    """A row of every recording of the list that the stage `record` writes; none where it has not run."""
    return pa.Table.from_pylist(orjson.loads(listing.read_bytes()) if listing.exists() else [], schema=RECORDINGS)


def parameter_table(sections: Mapping[str, Any]) -> pa.Table:
    """A row of every value of the sections of params.yaml."""
    rows = [(stage, ".".join(words), value) for stage, values in sections.items() for words, value in _leaves(values)]
    as_text = [value if isinstance(value, str) else orjson.dumps(value).decode() for _, _, value in rows]
    return _table({"stage": [row[0] for row in rows], "name": [row[1] for row in rows], "value": as_text}, PARAMETERS)


def _leaves(value: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Values by the words of their name; lists are values."""
    if not isinstance(value, Mapping):
        yield (), value
        return
    for name, inner in value.items():
        yield from ((((str(name), *words)), leaf) for words, leaf in _leaves(inner))


def _columns(shard: Path, names: list[str]) -> pa.Table:
    try:
        return pq.read_table(shard, columns=names, partitioning=None)
    except (pa.ArrowException, OSError) as error:
        what = str(error).splitlines()[0]
        raise UnusableInput(f"{shard} is no whole shard ({what}): make it again", reason="truncated") from None


def _table(columns: Mapping[str, Any], schema: pa.Schema) -> pa.Table:
    arrays = [column if isinstance(column, pa.ChunkedArray) else pa.array(column) for column in columns.values()]
    return pa.table(dict(zip(columns, arrays, strict=True))).cast(schema)
