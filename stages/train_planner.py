"""Stage train_planner@<name>: learn a planner from the train split's logs, and plan the validation logs with their true goals.

argv: scenarios (folder with train and val), the checker's limits (JSON), model (folder; its name is the planner's), metrics
(JSON), curve of loss and error (CSV). Times go to the cost table: training and planning apart, on a GPU in wall time, too.
An interrupted training goes on from `.drivegen/checkpoints/`, in a folder named after everything that it depends on.
"""

import hashlib
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

from drivegen import plugins
from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.errors import UnusableInput
from drivegen.lanes.graph import LaneGraph
from drivegen.planners._requests import examples_from_logs
from drivegen.planners._scores import drawn_tracks, score
from drivegen.planners.base import Examples, Planner, PlanRequests
from drivegen.samples import Violation
from drivegen.scenario import Scenario, Trajectories
from drivegen.settings import Count, Share
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards
from drivegen.training import loop
from drivegen.training.curve import write_curve
from stages._door import build, enter, require, spread_splits

CHECKPOINTS = Path(".drivegen/checkpoints")


@dataclass(frozen=True)
class Params:
    """What all planners share, and the settings of each.

    Attributes:
        seen: share of the steps at which a track must have been seen to be learnt from.
        scored: validation tracks that are planned for the metrics, at most. samples: trajectories for each of them.
        scored_scenes: planners too slow for all tracks, and the number of scenes that theirs are taken from.
        planners: settings by planner name, as its `Plugin.Settings` says.
    """

    training_seed: int
    workers: Count
    seen: Share
    scored: Count
    samples: Count
    scored_scenes: dict[str, int]
    planners: dict[str, Any]


def main(params: Params, scenarios: Path, limits: Path, model: Path, metrics: Path, curve: Path) -> dict[str, float]:
    """Train, save, score."""
    name = model.name
    plugin = plugins.load("planners", name)
    if name not in params.planners:
        raise UnusableInput(f"params.yaml: train_planner.planners has no settings for {name!r}")
    settings = build(plugin.Settings, params.planners[name], f"params.yaml: train_planner.planners.{name}")
    train, validation = _examples(scenarios, params)
    checkpoints = CHECKPOINTS / _key(params, settings, scenarios)
    judge = _Judge(require(limits, "run the calibrate stage"))
    planner: Planner = plugin(settings)
    took: dict[str, float] = {"planned": 0.0}
    with _timed("training", took):
        rows = planner.fit(train, validation, params.training_seed, checkpoints, _say(name))
    planner.save(model)
    write_curve(curve, rows, error="ade")
    counts = {"train_tracks": len(train), "validation_tracks": len(validation), "steps": rows[-1].step}
    epochs = round(rows[-1].step * settings.training.batch / max(len(train), 1), 2)
    drawn = drawn_tracks(validation, params.scored, params.scored_scenes.get(name), params.training_seed)

    def sample(scenes: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        with _timed("planning", took):
            took["planned"] += len(requests)
            return planner.sample(scenes, requests)

    scores = score(sample, validation, drawn, params.samples, params.training_seed, judge)
    write_json(metrics, {"planner": name, **counts, "epochs": epochs, "validation_loss": rows[-1].validation, **scores})
    shutil.rmtree(checkpoints, ignore_errors=True)
    return {**{key: float(value) for key, value in counts.items()}, **took}


@contextmanager
def _timed(what: str, took: dict[str, float]) -> Iterator[None]:
    """Add what the block takes to `took`: `<what>_cpu_seconds` and, where there is a GPU, `<what>_gpu_seconds` (wall time)."""
    cpu, wall = time.process_time(), time.perf_counter()
    yield
    took[f"{what}_cpu_seconds"] = took.get(f"{what}_cpu_seconds", 0.0) + time.process_time() - cpu
    if loop.device().type == "cuda":
        took[f"{what}_gpu_seconds"] = took.get(f"{what}_gpu_seconds", 0.0) + time.perf_counter() - wall


class _Judge:
    """The checker's rules that need no other vehicle: `off_road` and `illegal` (any of them, off the road included)."""

    def __init__(self, limits: Path) -> None:
        self.limits = Limits.from_json(orjson.loads(limits.read_bytes()), str(limits))
        self.checkers: dict[str, SceneChecker] = {}

    def __call__(
        self, scenarios: Sequence[Scenario], requests: PlanRequests, motion: Trajectories
    ) -> dict[str, NDArray[np.bool_]]:
        violation = np.zeros(len(requests), np.uint16)
        for number in np.unique(requests.scenario).tolist():
            scenario = scenarios[number]
            if scenario.scenario_id not in self.checkers:
                self.checkers[scenario.scenario_id] = SceneChecker(scenario, self.limits)
            rows = np.flatnonzero(requests.scenario == number)
            found = self.checkers[scenario.scenario_id].alone(requests.vehicle[rows], motion[rows].until(scenario.steps))
            violation[rows] = found.violation
        return {"off_road": (violation & int(Violation.OFF_ROAD)) > 0, "illegal": violation > 0}


def _examples(scenarios: Path, params: Params) -> tuple[Examples, Examples]:
    """Requests and motion of the logged tracks of both splits, shard by shard."""
    train, validation = spread_splits(
        _shard_examples,
        scenarios,
        lambda split: [(shard, params.seen, params.training_seed) for shard in shards(split)],
        params.workers,
        "tracks",
    )
    return Examples.join(train), Examples.join(validation)


def _shard_examples(task: tuple[Path, float, int]) -> Examples:
    shard, seen, seed = task
    scenarios = read_shard(shard)
    return examples_from_logs(scenarios, [LaneGraph.of(s.map) for s in scenarios], seen, seed)


def _key(params: Params, settings: Any, scenarios: Path) -> str:
    """A name for everything that the weights depend on: settings, seed, data and the code that learns."""
    digest = hashlib.sha256(repr((asdict(settings), params.training_seed, params.seen)).encode())
    root = Path(__file__).parents[1] / "drivegen"
    code = sorted(path for folder in ("planners", "training", "lanes", "render") for path in (root / folder).glob("*.py"))
    for path in [*code, *shards(scenarios / "train"), *shards(scenarios / "val")]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:24]


def _say(name: str) -> Callable[[str], None]:
    return lambda line: print(f"train_planner {name}: {line}", flush=True)


if __name__ == "__main__":
    enter("train_planner", Params, main)
