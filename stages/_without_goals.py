"""What stages rollout_rival and rollout_baseline do: K futures of every test scenario by a generator that follows no goals.

Bounds are told what the log says; everybody else, and the checker that judges them, know the first frame alone.
They are two only because their deps differ: a rival that is trained again must not run the baselines again.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from drivegen.checker.verdicts import judged, read_limits
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.methods import BOUND
from drivegen.core.settings import Count
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import require, spread


@dataclass(frozen=True)
class Params:
    """`samples`: futures of each scenario, as many as of every method."""

    sampling_seed: int
    workers: Count
    samples: Count


def main(params: Params, scenarios: Path, models: Path, generated: Path) -> dict[str, float]:
    """Generate and judge shard after shard."""
    files, work = shards(require(scenarios, "run the ingest stage")), partial(_generate_shard, params, models, generated)
    counts = [count for _, count in spread(work, files, params.workers, f"rollout {generated.name}")]
    return {"scenarios": float(sum(counts))}


def _generate_shard(params: Params, models: Path, out: Path, shard: Path) -> int:
    name, scenarios = out.name, read_shard(shard)
    plugin = plugins.load("generators", name)
    if plugin.about.kind != BOUND:
        scenarios = [first_frame(scenario) for scenario in scenarios]
    if plugin.about.goals is not None:
        raise UnusableInput(f"generator {name!r} follows goals: of the lists in params.yaml it belongs in run.own")
    limits = read_limits(models)
    futures = plugin(models, None).generate(scenarios, params.samples, params.sampling_seed)
    write_samples(out / shard.name, [judged(s, m, limits) for s, m in zip(scenarios, futures, strict=True)])
    return len(scenarios)
