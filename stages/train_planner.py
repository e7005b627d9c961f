"""Stage train_planner@<name>: learn a planner from the train split's logs, and plan the validation logs with their true goals.

argv: scenarios (folder with train and val), model (folder; its name is the planner's), metrics (JSON), loss curve (CSV).
An interrupted training goes on from `.drivegen/checkpoints/`, in a folder named after everything that it depends on.
"""

import hashlib
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from drivegen import plugins
from drivegen.errors import UnusableInput
from drivegen.lanes.graph import LaneGraph
from drivegen.planners._requests import examples_from_logs
from drivegen.planners._scores import score
from drivegen.planners.base import Examples
from drivegen.store.files import whole, write_json
from drivegen.store.scenarios import read_shard, shards
from drivegen.training.curve import LossRow
from stages._door import build, enter, require, spread

CHECKPOINTS = Path(".drivegen/checkpoints")


@dataclass(frozen=True)
class Params:
    """What all planners share, and the settings of each.

    Attributes:
        seen: share of the steps at which a track must have been seen to be learnt from.
        scored: validation tracks that are planned for the metrics, at most. samples: trajectories for each of them.
        planners: settings by planner name, as its `Plugin.Settings` says.
    """

    seed: int
    workers: int
    seen: float
    scored: int
    samples: int
    planners: dict[str, Any]


def main(params: Params, scenarios: Path, model: Path, metrics: Path, curve: Path) -> dict[str, float]:
    """Train, save, score."""
    name = model.name
    plugin = plugins.load("planners", name)
    if name not in params.planners:
        raise UnusableInput(f"params.yaml: train_planner.planners has no settings for {name!r}")
    settings = build(plugin.Settings, params.planners[name], f"params.yaml: train_planner.planners.{name}")
    train = _examples(require(scenarios / "train", "run the ingest stage"), params)
    validation = _examples(scenarios / "val", params)
    checkpoints = CHECKPOINTS / _key(params, settings, scenarios)
    planner = plugin(settings)
    rows = planner.fit(train, validation, params.seed, checkpoints, _say(name))
    planner.save(model)
    _write_curve(curve, rows)
    counts = {"train_tracks": len(train), "validation_tracks": len(validation), "steps": rows[-1].step}
    scores = score(planner, validation, params.scored, params.samples, params.seed)
    write_json(metrics, {"planner": name, **counts, "validation_loss": rows[-1].validation, **scores})
    shutil.rmtree(checkpoints, ignore_errors=True)
    return {key: float(value) for key, value in counts.items()}


def _examples(split: Path, params: Params) -> Examples:
    """Requests and motion of a split's logged tracks, shard by shard in processes of their own."""
    tasks = [(shard, params.seen, params.seed) for shard in shards(split)] if split.exists() else []
    return Examples.join([part for _, part in spread(_shard_examples, tasks, params.workers, f"tracks of {split.name}")])


def _shard_examples(task: tuple[Path, float, int]) -> Examples:
    shard, seen, seed = task
    scenarios = read_shard(shard)
    return examples_from_logs(scenarios, [LaneGraph.of(s.map) for s in scenarios], seen, seed)


def _key(params: Params, settings: Any, scenarios: Path) -> str:
    """A name for everything that the weights depend on: settings, seed, data and the code that learns."""
    digest = hashlib.sha256(repr((asdict(settings), params.seed, params.seen)).encode())
    root = Path(__file__).parents[1] / "drivegen"
    code = sorted(path for folder in ("planners", "training", "lanes", "render") for path in (root / folder).glob("*.py"))
    for path in [*code, *shards(scenarios / "train"), *(shards(scenarios / "val") if (scenarios / "val").exists() else [])]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:24]


def _say(name: str) -> Callable[[str], None]:
    return lambda line: print(f"train_planner {name}: {line}", flush=True)


def _write_curve(path: Path, rows: list[LossRow]) -> None:
    lines = ["step,train,validation", *(f"{row.step},{row.train:.6f},{row.validation:.6f}" for row in rows)]
    with whole(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    enter("train_planner", Params, main)
