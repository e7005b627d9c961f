"""Stage train_planner@<name>: learn a planner from the train split's logs, and plan the validation logs with their true goals.

argv: scenarios (folder with train and val), the checker's limits (JSON), model (folder; its name is the planner's), metrics
(JSON), curve of loss and error (CSV). Times go to the cost table: training and planning apart, on a GPU in wall time, too.
An interrupted training goes on from `.drivegen/checkpoints/`, in a folder named after everything that it depends on.
"""

import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.verdicts import SingleJudge, read_limits_file
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import Count, Share
from drivegen.planners.base import Examples, Planner, PlanRequests, Stream
from drivegen.planners.shared.requests import examples_from_logs
from drivegen.planners.shared.scores import drawn_tracks, score
from drivegen.roads.graph import LaneGraph
from drivegen.store.files import write_json
from drivegen.store.lookup import evenly
from drivegen.store.scenarios import read_shard, shards
from drivegen.training import checkpoint
from drivegen.training.curve import plateau, write_curve
from drivegen.training.timing import timed
from stages._door import build, spread_splits

CHECKPOINTS = Path(".drivegen/checkpoints")
VALIDATION_SHARDS = 10
"""Of more, so many are looked at, evenly spread: their tracks stay in memory, with their maps."""


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
    (planner, settings), single = _untrained(model.name, params), SingleJudge(read_limits_file(limits))
    train, validation = _examples(scenarios, params)
    data = [*shards(scenarios / "train"), *shards(scenarios / "val")]
    inputs = (model.name, asdict(settings), params.training_seed, params.seen)
    checkpoints = CHECKPOINTS / checkpoint.name_of(inputs, data, checkpoint.source_digest("drivegen", "stages"))
    costs, say = {"planned": 0.0}, partial(print, f"train_planner {model.name}:", flush=True)
    with timed("training", costs):
        rows = planner.fit(train, validation, params.training_seed, checkpoints, say)
    planner.save(model)
    write_curve(curve, rows, error="ade")
    counts = {"train_tracks": train.tracks, "validation_tracks": len(validation), "steps": rows[-1].step}
    epochs = round(rows[-1].step * settings.training.batch / planner.learnt_from, 2)

    def sample(scenes: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        with timed("planning", costs):
            costs["planned"] += len(requests)
            return planner.sample(scenes, requests)

    def judge(scenes: Sequence[Scenario], requests: PlanRequests, motion: Trajectories) -> dict[str, NDArray[np.bool_]]:
        return single(scenes, requests.scenario, requests.vehicle, motion)

    tracks = drawn_tracks(validation, params.scored, params.scored_scenes.get(model.name), params.training_seed)
    scores = score(sample, validation, tracks, params.samples, params.training_seed, judge)
    about = {"planner": model.name, **counts, "epochs": epochs, "validation_loss": rows[-1].validation, "plateau": plateau(rows)}
    write_json(metrics, {**about, **scores})
    shutil.rmtree(checkpoints, ignore_errors=True)
    return {**{key: float(value) for key, value in counts.items()}, **costs}


def _untrained(name: str, params: Params) -> tuple[Planner, Any]:
    """The planner plugin called `name` and its settings; raises UnusableInput where params know none."""
    plugin = plugins.load("planners", name)
    if name not in params.planners:
        raise UnusableInput(f"params.yaml: train_planner.planners has no settings for {name!r}")
    settings = build(plugin.Settings, params.planners[name], f"params.yaml: train_planner.planners.{name}")
    return plugin(settings), settings


def _examples(scenarios: Path, params: Params) -> tuple[Stream, Examples]:
    """Requests and motion of the logged tracks: of the train split shard by shard, of the validation split all at once."""

    def tasks(split: Path) -> list[tuple[Path, float, int]]:
        files = shards(split)
        chosen = evenly(len(files), VALIDATION_SHARDS if split.name == "val" else len(files))
        return [(files[n], params.seen, params.training_seed) for n in chosen]

    parts = (part for _, part in spread_splits(_shard_examples, scenarios, tasks, params.workers, "tracks"))
    validation = Examples.join(list(islice(parts, len(tasks(scenarios / "val")))))
    return Stream(parts), validation


def _shard_examples(task: tuple[Path, float, int]) -> Examples:
    shard, least_seen, seed = task
    return examples_from_logs(logs := read_shard(shard), [LaneGraph.of(log.map) for log in logs], least_seen, seed)
