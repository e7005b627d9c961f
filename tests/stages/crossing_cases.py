"""Scenes in which somebody stands beside the road, and cases in which it drives across, on disk as stages leave them."""

from pathlib import Path

import numpy as np

from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from tests.scenes import drive, scenario, stack, straight_road

LINE = straight_road().centreline[0].astype(np.float64)
SHARD = "shard-00000.parquet"
ACROSS = np.array([[35.0, -25.0], [35.0, 25.0]]) + LINE[0]
"""A way across that of the target, which is where the two meet after 2.5 s at 10 m/s."""


def scene(number: int, speed: float = 0.0) -> Scenario:
    """The target drives straight on; the other stands beside the road, or drives across."""
    return scenario(straight_road(), stack([drive(LINE, 10, 10, 61), drive(ACROSS, 0, speed, 61)]), f"run{number}-0")


def write_cases(root: Path) -> None:
    """Below `root`: three scenes, in two of which IDM's case is that somebody drives across."""
    scenes = [scene(n) for n in range(3)]
    write_shard(root / "test" / SHARD, scenes)
    as_it_is = [Samples.without_goals(s.scenario_id, "drivegen", s.log[np.newaxis]) for s in scenes]
    write_samples(root / "round" / SHARD, as_it_is)
    cases = [Samples.without_goals(s.scenario_id, "random", scene(n, 10.0).log[np.newaxis]) for n, s in enumerate(scenes[:2])]
    write_samples(root / "attack/idm/random.legal.10/samples.parquet", cases)
    write_samples(root / "attack/idm/cat.legal.10/samples.parquet", [])
