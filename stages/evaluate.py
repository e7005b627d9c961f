"""Stage evaluate: how realistic, diverse and safe one method's traffic is, against the log of the same scenarios.

argv: scenarios of one split, generated samples of one method, results (Parquet rows), all means with their intervals and
counts of labels (JSON), the few numbers that DVC shows (JSON).
"""

from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.errors import UnusableInput
from drivegen.metrics.displacement import scene_errors, scored_steps, summarise
from drivegen.metrics.diversity import (
    OwnFrames,
    own_frames,
    plain_differences,
    random_pairs,
    ratio,
    squared_differences,
)
from drivegen.metrics.intervals import bootstrap_means
from drivegen.metrics.labels import label
from drivegen.metrics.safety import safety_rates, violation_shares
from drivegen.samples import Samples
from drivegen.scenario import Scenario, Trajectories
from drivegen.seeds import rng
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, run_id, write_results
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, require, spread

SHOWN = (
    "min_sade",
    "min_sfde",
    "mean_sade",
    "mean_sfde",
    "diversity_ratio",
    "collision_per_vehicle",
    "off_road_per_vehicle",
    "illegal_per_vehicle",
    "scenarios",
)
"""What `dvc metrics show` prints: one row a method."""


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws for intervals; `splits` random splits of the set into pairs, for diversity."""

    seed: int
    workers: int
    draws: int
    splits: int


@dataclass(frozen=True)
class Scored:
    """One scene's numbers, and the three motions (N, T) that diversity compares."""

    scenario: str
    metrics: dict[str, float]
    log: Trajectories
    best: Trajectories
    any_sample: Trajectories


def main(params: Params, scenarios: Path, generated: Path, results: Path, details: Path, summary: Path) -> dict[str, float]:
    """Score every shard, then the whole set."""
    pairs = [(shard, require(generated / shard.name, "run the rollout stage"), params.seed) for shard in shards(scenarios)]
    scenes: list[Scored] = []
    for _, part in spread(_score_shard, pairs, params.workers, f"evaluate {summary.stem}"):
        scenes += part
    if not scenes:
        raise UnusableInput(f"{scenarios} holds no scenario with a log to compare with", reason="no-scenarios")
    run = Run(run_id(asdict(params), [scenarios, generated]), "evaluate", summary.stem, "", params.seed, "")
    write_results(results, _rows(run, scenes))
    numbers = _summary(scenes, params) | _diversity(scenes, params)
    write_json(details, numbers)
    write_json(summary, {name: numbers[name] for name in SHOWN})
    return {"scenarios": float(len(scenes))}


def _score_shard(task: tuple[Path, Path, int]) -> list[Scored]:
    shard, generated, seed = task
    by_id = {samples.scenario_id: samples for samples in read_samples(generated)}
    out = []
    for scenario in read_shard(shard):
        if scenario.scenario_id not in by_id:
            raise UnusableInput(f"{generated} lacks scenario {scenario.scenario_id}: run the rollout stage again")
        if scenario.log is not None:
            out.append(_score(scenario, scenario.log, by_id[scenario.scenario_id], seed))
    return out


def _score(scenario: Scenario, log: Trajectories, samples: Samples, seed: int) -> Scored:
    sade, sfde = scene_errors(samples.motion, log)
    chosen = int(rng(seed, "evaluate", "any", scenario.scenario_id).integers(len(sade)))
    metrics = {
        **asdict(summarise(sade, sfde)),
        **asdict(safety_rates(samples)),
        **{f"violation.{kind}": share for kind, share in violation_shares(samples).items()},
        "attempts": float(samples.attempts.mean()),
        "agent_steps": float(scored_steps(log).sum()),
        "vehicles": float(len(scenario.vehicles)),
        **label(scenario, log).as_rows(),
    }
    best, any_sample = (_masked(samples.motion[k], log) for k in (int(np.argmin(sade)), chosen))
    return Scored(scenario.scenario_id, metrics, log, best, any_sample)


def _masked(motion: Trajectories, log: Trajectories) -> Trajectories:
    return replace(motion, valid=motion.valid & log.valid)


def _rows(run: Run, scenes: list[Scored]) -> list[pa.Table]:
    ids = [scene.scenario for scene in scenes]
    names = sorted({name for scene in scenes for name in scene.metrics})
    return [result_rows(run, ids, {name: _column(scenes, name) for name in names})]


def _column(scenes: list[Scored], name: str) -> NDArray[np.float64]:
    return np.array([scene.metrics.get(name, np.nan) for scene in scenes])


def _summary(scenes: list[Scored], params: Params) -> dict[str, float]:
    """Means over scenarios with their intervals; labels are counted, not averaged."""
    labels = {name for scene in scenes for name in scene.metrics if name.startswith(("label.", "manoeuvre."))}
    names = sorted({name for scene in scenes for name in scene.metrics} - labels - {"agent_steps", "vehicles"})
    table = np.stack([_column(scenes, name) for name in names], axis=1)
    intervals = bootstrap_means(table, params.draws, rng(params.seed, "evaluate", "bootstrap"))
    out = {name: float(np.nansum(_column(scenes, name))) for name in sorted(labels)}
    for name, interval in zip(names, intervals, strict=True):
        out |= {name: interval.value, f"{name}.low": interval.low, f"{name}.high": interval.high}
    totals = {name: float(_column(scenes, name).sum()) for name in ("agent_steps", "vehicles")}
    return out | totals | {"scenarios": len(scenes)}


def _diversity(scenes: list[Scored], params: Params) -> dict[str, float]:
    """Diversity of the log, the best sample and a random sample, and both ratios, by squared and by plain norm."""
    pairs = random_pairs(len(scenes), params.splits, rng(params.seed, "evaluate", "pairs"))
    sets: dict[str, OwnFrames] = {
        "log": own_frames([scene.log for scene in scenes]),
        "": own_frames([scene.best for scene in scenes]),
        "any_sample": own_frames([scene.any_sample for scene in scenes]),
    }
    out: dict[str, float] = {"diversity_pairs": len(pairs)}
    for norm, differences in {"": squared_differences, "plain": plain_differences}.items():
        values = {name: differences(frames, pairs) for name, frames in sets.items()}
        for name in sets:
            key = "_".join(word for word in ("diversity", name, norm) if word)
            out[key] = float(values[name].mean()) if len(pairs) else np.nan
            if name != "log":
                stream = rng(params.seed, "evaluate", "diversity", norm, name)
                interval = ratio(values[name], values["log"], pairs, params.draws, stream)
                key = "_".join(word for word in ("diversity_ratio", name, norm) if word)
                out |= {key: interval.value, f"{key}.low": interval.low, f"{key}.high": interval.high}
    return out


if __name__ == "__main__":
    enter("evaluate", Params, main)
