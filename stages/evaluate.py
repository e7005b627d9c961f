"""Stage evaluate: how realistic, diverse and safe one method's traffic is, against the log of the same scenarios.

argv: scenarios of one split, generated samples of one method, results (Parquet rows), all means with their intervals and
counts of labels (JSON), the few numbers that DVC shows (JSON).
"""

from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np

from drivegen.core.errors import UnusableInput
from drivegen.core.seeds import rng
from drivegen.core.settings import Count
from drivegen.metrics.road_edge import FARTHEST, RoadEdges
from drivegen.metrics.scene import Scored, Settings, score
from drivegen.metrics.whole import Scenes, columns, sample_columns, summary
from drivegen.roads.drivable import CELL, covered, road_surface
from drivegen.store.columns import Filed
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import SCRATCH, require, spread

SHOWN = ("min_sade", "mean_sade", "realism", "illegal_per_vehicle")
"""What `dvc metrics show` prints: one row a method, no wider than a screen."""


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws for intervals; `splits` random splits of the set into pairs, for diversity."""

    seed: int
    workers: Count
    draws: Count
    splits: Count
    measured: Settings


@dataclass(frozen=True)
class Task:
    """One shard of scenarios and the samples of one method on it."""

    shard: Path
    generated: Path
    params: Params


def main(params: Params, scenarios: Path, generated: Path, results: Path, details: Path, shown: Path) -> dict[str, float]:
    """Score every shard, then the whole set."""
    tasks = [Task(shard, require(generated / shard.name, "run the rollout stage"), params) for shard in shards(scenarios)]
    parts = spread(_score_shard, tasks, params.workers, f"evaluate {shown.stem}")
    scenes = Scenes.of((scene for _, part in parts for scene in part), partial(Filed, SCRATCH))
    if not len(scenes):
        raise UnusableInput(f"{scenarios} holds no scenario with a log to compare with", reason="no-scenarios")
    run = Run.of("evaluate", shown.stem, asdict(params), [scenarios, generated], method=shown.stem)
    table = columns(scenes, params.measured)
    ids, sample, each = sample_columns(scenes)
    of_scenes = (result_rows(run, list(scenes.scenario), {name: table[name]}) for name in sorted(table))
    of_samples = (result_rows(run, ids, {name: each[name]}, sample) for name in sorted(each))
    write_results(results, chain(of_scenes, of_samples))
    numbers = summary(scenes, table, params.seed, params.draws, params.splits)
    write_json(details, numbers)
    write_json(shown, {name: numbers[name] for name in SHOWN})
    return {"scenarios": float(len(scenes))}


def _score_shard(task: Task) -> list[Scored]:
    by_id = {samples.scenario_id: samples for samples in read_samples(task.generated)}
    out = []
    for scenario in read_shard(task.shard):
        if scenario.scenario_id not in by_id:
            raise UnusableInput(f"{task.generated} lacks scenario {scenario.scenario_id}: run the rollout stage again")
        if scenario.log is not None:
            samples = by_id[scenario.scenario_id]
            places = np.concatenate([motion.position[motion.valid] for motion in (scenario.log, samples.motion)])
            road = road_surface(scenario.map, covered(places, scenario.vehicles.size), FARTHEST)
            edges = RoadEdges(road.outside, road.origin, CELL, road.beyond_rim)
            stream = rng(task.params.seed, "evaluate", "any", scenario.scenario_id)
            out.append(score(scenario, scenario.log, samples, edges, task.params.measured, stream))
    return out
