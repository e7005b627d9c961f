"""What leads from a result to where it lies: tables of scenarios, of samples, of recordings and of parameters.

They are read from what the stages wrote, the small columns of shards alone: no motion, no map.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import orjson
import pyarrow as pa

from drivegen.core.intervals import recording
from drivegen.store import samples, scenarios
from drivegen.store.lists import read_shard_table
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
"""Every number of the parameters: its section, its dotted name there, its value as text (JSON where it is no word)."""


def read_scenarios(folders: Mapping[str, Path]) -> pa.Table:
    """A row of every scenario in the shards of `folders`, by split; folders that are not there hold none."""
    parts = [_scenarios(split, shard) for split, folder in folders.items() for shard in shards(folder)]
    return pa.concat_tables([SCENARIOS.empty_table(), *parts])


def _scenarios(split: str, shard: Path) -> pa.Table:
    names = ["scenario_id", "source", "city", "horizon", "vehicles.kind"]
    table = read_shard_table(shard, scenarios.KIND, scenarios.VERSION, names)
    columns = {
        "scenario": table["scenario_id"],
        "split": [split] * table.count,
        "source": table["source"],
        "city": table["city"],
        "log": [recording(scenario) for scenario in table["scenario_id"]],
        "shard": [str(shard)] * table.count,
        "vehicles": [len(kinds) for kinds in table["vehicles.kind"]],
        "steps": [horizon + 1 for horizon in table["horizon"]],
    }
    return pa.table(columns, SCENARIOS)


def read_sample_table(stage: str, item: str, folder: Path) -> pa.Table:
    """A row of every future in the shards of `folder`, which `item` of `stage` made; none where there is no such folder."""
    return pa.concat_tables([SAMPLES.empty_table(), *(_samples(stage, item, shard) for shard in shards(folder))])


def _samples(stage: str, item: str, shard: Path) -> pa.Table:
    names = ["scenario_id", "method", "samples", "vehicles", "violation", "dropped", "left_map"]
    table = read_shard_table(shard, samples.KIND, samples.VERSION, names)
    of = [row for row in range(table.count) for _ in range(table["samples"][row])]

    def flagged(name: str) -> list[int]:
        flags = zip(table[name], table["samples"], strict=True)
        return [int(n) for values, count in flags for n in (values.reshape(count, -1) > 0).sum(axis=1)]

    columns = {
        "stage": [stage] * len(of),
        "item": [item] * len(of),
        "method": [table["method"][row] for row in of],
        "scenario": [table["scenario_id"][row] for row in of],
        "sample": [sample for count in table["samples"] for sample in range(count)],
        "shard": [str(shard)] * len(of),
        "vehicles": [table["vehicles"][row] for row in of],
        **{to: flagged(name) for to, name in (("illegal", "violation"), ("dropped", "dropped"), ("left_map", "left_map"))},
    }
    return pa.table(columns, SAMPLES)


def read_recordings(listing: Path) -> pa.Table:
    """A row of every recording of the list that the stage `record` writes; none where it has not run."""
    return pa.Table.from_pylist(orjson.loads(listing.read_bytes()) if listing.exists() else [], schema=RECORDINGS)


def parameter_table(sections: Mapping[str, Any]) -> pa.Table:
    """A row of every value of the sections of the parameters."""
    rows = [(stage, ".".join(words), value) for stage, values in sections.items() for words, value in _leaves(values)]
    as_text = [value if isinstance(value, str) else orjson.dumps(value).decode() for _, _, value in rows]
    return pa.table({"stage": [row[0] for row in rows], "name": [row[1] for row in rows], "value": as_text}, PARAMETERS)


def _leaves(value: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Values by the words of their name; lists are values."""
    if not isinstance(value, Mapping):
        yield (), value
        return
    for name, inner in value.items():
        yield from ((((str(name), *words)), leaf) for words, leaf in _leaves(inner))
