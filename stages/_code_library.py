"""The training logs whose scenario codes LCTGen places vehicles by: drawn from all shards, as each holds but a few networks."""

from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from pathlib import Path

from drivegen.core.scenario import Scenario
from drivegen.store.draw import draw_places
from drivegen.store.scenarios import read_shard
from stages._door import require

LOGS = 100
"""Scenes that are drawn."""


def library(scenarios: Path, seed: int) -> Iterator[Scenario]:
    """Those of the train split that have a log, in the order of the split; one shard is in memory at a time."""
    places = sorted(draw_places(seed, require(scenarios / "train", "run the ingest stage"), LOGS))
    for shard, drawn in groupby(places, itemgetter(0)):
        scenes = read_shard(shard)
        yield from (scenes[row] for _, row in drawn if scenes[row].log is not None)
