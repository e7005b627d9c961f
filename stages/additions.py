"""Stage additions@<method>: one method's futures of the test scenarios as they are, and with the same additions as every other's.

argv: scenarios (folder of shards), models (folder with the checker's limits), generated (folder; its name is the method's),
results (Parquet rows: "<additions>/<metric>", "none" for the futures as they are), their means over the scenarios that are as
long as most (JSON).
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.verdicts import read_limits
from drivegen.core.first_frame import first_frame
from drivegen.core.intervals import usual_length
from drivegen.core.settings import Share
from drivegen.metrics.displacement import scene_errors, standing_at_exit, summarise
from drivegen.metrics.safety import safety_rates
from drivegen.rollout.additions import VARIANTS, with_additions
from drivegen.store.files import write_json
from drivegen.store.lookup import futures_in
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.scenarios import shards
from stages._door import require, spread


@dataclass(frozen=True)
class Params:
    """`tempo`: share of how far a vehicle gets that all of a future have in common."""

    sampling_seed: int
    workers: int
    tempo: Share


@dataclass(frozen=True)
class Task:
    """One shard of scenarios and of a method's samples."""

    shard: Path
    generated: Path
    models: Path
    params: Params


def main(params: Params, scenarios: Path, models: Path, generated: Path, results: Path, means: Path) -> dict[str, float]:
    """Choose anew and score, shard after shard."""
    tasks = [Task(shard, require(generated / shard.name, "run the rollout stage"), models, params) for shard in shards(scenarios)]
    by_scene: dict[str, dict[str, float]] = {}
    for _, part in spread(_score_shard, tasks, params.workers, f"additions {generated.name}"):
        by_scene |= part
    names = sorted({name for metrics in by_scene.values() for name in metrics})
    columns: dict[str, NDArray[np.float64]] = {name: np.array([metrics[name] for metrics in by_scene.values()]) for name in names}
    settings = {**asdict(params), "seed": params.sampling_seed}
    run = Run.of("additions", generated.name, settings, [scenarios, generated, models / "limits.json"], method=generated.name)
    write_results(results, [result_rows(run, list(by_scene), columns)])
    write_json(means, _means(columns))
    return {"scenarios": float(len(by_scene))}


def _means(columns: Mapping[str, NDArray[np.float64]]) -> dict[str, float]:
    """By name, of values (S,), those of scenarios that are as long as most: errors grow with the time that is foreseen."""
    return {name: float(np.mean(column[columns["steps"] == usual_length(columns["steps"])])) for name, column in columns.items()}


def _score_shard(task: Task) -> dict[str, dict[str, float]]:
    """Metrics of every scenario with a log, by its id."""
    limits, by_scene = read_limits(task.models), {}
    for scenario, samples in futures_in(task.generated, task.shard.parent):
        if scenario.log is None:
            continue
        metrics = {"steps": float(scenario.steps)}
        for additions in VARIANTS:
            other = with_additions(
                first_frame(scenario), samples, limits, additions, task.params.tempo, task.params.sampling_seed
            )
            errors = summarise(*scene_errors(standing_at_exit(other.motion, scenario.log), scenario.log))
            name = "+".join(additions) or "none"
            metrics |= {f"{name}/{key}": value for key, value in (asdict(errors) | asdict(safety_rates(other))).items()}
        by_scene[scenario.scenario_id] = metrics
    return by_scene
