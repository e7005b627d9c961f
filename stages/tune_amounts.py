"""Stage tune_amounts: more of DriveGen's futures of each test scenario than the pipeline makes, for tuning on many.

argv: scenarios (folder of shards), models (folder), futures (folder of shards, as many).
They begin with the first frame of a scenario, like the pipeline's own.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from drivegen.core import plugins
from drivegen.core.first_frame import first_frame
from drivegen.core.settings import Count
from drivegen.generators.base import Settings
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import require, spread

METHOD = "drivegen"


@dataclass(frozen=True)
class Params:
    """`samples`: futures of each scenario, as many as the largest of `tune.amounts`."""

    seed: int
    workers: Count
    samples: Count
    generation: Settings


def main(params: Params, scenarios: Path, models: Path, out: Path) -> None:
    """Shard after shard."""
    files, work = shards(require(scenarios, "run the ingest stage")), partial(_generate_shard, params, models, out)
    for _ in spread(work, files, params.workers, "tune_amounts"):
        pass


def _generate_shard(params: Params, models: Path, out: Path, shard: Path) -> None:
    scenarios = [first_frame(scenario) for scenario in read_shard(shard)]
    generator = plugins.load("generators", METHOD)(models, params.generation)
    write_samples(out / shard.name, generator.generate(scenarios, params.samples, params.seed))
