"""A scenario by its id, out of the folders in which the pipeline leaves shards."""

import re
from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards

_SAMPLE = re.compile(r"(.+)-s(\d{2,})")


def find_scenario(wanted: str, folders: Sequence[Path]) -> tuple[Path, Scenario] | None:
    """The first scenario of that id (folders' names have dashes for colons: both forms count) and its shard; None without one."""
    for shard in (shard for folder in folders for shard in shards(folder)):
        ids = _ids(shard)
        for row, scenario_id in enumerate(ids):
            if wanted in (scenario_id, scenario_id.replace(":", "-")):
                return shard, read_shard(shard)[row]
    return None


def find_sample(wanted: str, folders: Sequence[Path], generated: Path) -> tuple[Scenario, Samples, int] | None:
    """A future `<id>-s<number>`: its scenario, the samples of it in shards of `generated`, its number; None without one."""
    parts = _SAMPLE.fullmatch(wanted)
    place = find_scenario(parts[1], folders) if parts else None
    if parts is None or place is None or not (generated / place[0].name).exists():
        return None
    shard, scenario = place
    samples = next((s for s in read_samples(generated / shard.name) if s.scenario_id == scenario.scenario_id), None)
    number = int(parts[2])
    return (scenario, samples, number) if samples is not None and number < len(samples.dropped) else None


def _ids(shard: Path) -> list[str]:
    """None where the file is not whole: reading it as scenarios would say so, and another shard may have what is wanted."""
    try:
        ids: list[str] = pq.read_table(shard, columns=["scenario_id"])["scenario_id"].to_pylist()
    except (pa.ArrowException, OSError):
        return []
    return ids
