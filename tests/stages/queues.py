"""Queues on two lanes on disk, with all that stages read that look for what makes drivers fail in them."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from tests.models import two_lanes, write_random_goals
from tests.scenes import noisy_samples


def write_queues(root: Path, models: Path) -> None:
    """Below `root`: two shards of scenarios (`test`), whose samples (`round`) are the logs, `goals`, and a link to `models`."""
    for shard, speeds in (("shard-00000.parquet", (6.0, 8.0)), ("shard-00001.parquet", (9.0,))):
        scenes = [two_lanes(speed, f"queue{speed:.0f}-0") for speed in speeds]
        write_shard(root / "test" / shard, scenes)
        write_samples(root / "round" / shard, [replace(noisy_samples(s, 1), motion=s.log[np.newaxis]) for s in scenes])
        write_random_goals(root / "goals" / shard, scenes)
    (root / "models").symlink_to(models)
