"""Stage train_generator@<rival>: train a generator to compare with on the train split's logs, then score it on the val split.

argv: scenarios (folder with train and val), model (folder; its name is the generator's), metrics (JSON), loss curve (CSV).
An interrupted training goes on from `.drivegen/checkpoints/`, in a folder named after everything that it depends on.
"""

import shutil
import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.settings import Count
from drivegen.generators.shared.learned import Learned
from drivegen.metrics.displacement import scene_errors, summarise
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards
from drivegen.training import checkpoint
from drivegen.training.curve import kept, write_curve
from stages._door import build, enter, spread_splits

CHECKPOINTS = Path(".drivegen/checkpoints")


@dataclass(frozen=True)
class Params:
    """What all learned generators share, and the settings of each.

    Attributes:
        samples: futures of each validation scenario behind the metrics.
        generators: settings by name, as the generator's `Settings` says.
    """

    training_seed: int
    workers: Count
    samples: Count
    generators: dict[str, Any]


def main(params: Params, scenarios: Path, model: Path, metrics: Path, curve: Path) -> dict[str, float]:
    """Train, save, score."""
    plugin, settings = _chosen(model.name, params)
    train, validation = _examples(plugin, settings, scenarios, params.workers)
    inputs = (model.name, asdict(settings), params.training_seed)
    data = [*shards(scenarios / "train"), *shards(scenarios / "val")]
    checkpoints = CHECKPOINTS / checkpoint.name_of(inputs, data, checkpoint.source_digest("drivegen", "stages"))
    say = partial(print, f"train_generator {model.name}:", flush=True)
    began = time.process_time()
    generator, rows = plugin.fit(settings, train, validation, params.training_seed, checkpoints, say)
    trained = time.process_time() - began
    generator.save(model)
    write_curve(curve, rows)
    counts = {"train_examples": len(train), "validation_examples": len(validation), "steps": rows[-1].step}
    best = kept(rows)
    learnt = {"parameters": generator.parameters, "kept_step": best.step, "validation_loss": best.validation}
    scores = _scores(generator, scenarios / "val", params)
    for bound, told in generator.bounds().items():
        scores |= {f"{bound}.{key}": value for key, value in _scores(told, scenarios / "val", params, told_log=True).items()}
    write_json(metrics, {"generator": model.name, **counts, **learnt, **scores})
    shutil.rmtree(checkpoints, ignore_errors=True)
    return {**{key: float(value) for key, value in counts.items()}, "training_cpu_seconds": trained}


def _chosen(name: str, params: Params) -> tuple[type[Learned], Any]:
    """The plugin called `name` and its settings; raises UnusableInput where it does not learn or has none."""
    plugin = plugins.load("generators", name)
    if not issubclass(plugin, Learned):
        raise UnusableInput(f"generator {name!r} learns nothing: take it out of run.rivals in params.yaml")
    if name not in params.generators:
        raise UnusableInput(f"params.yaml: train_generator.generators has no settings for {name!r}")
    return plugin, build(plugin.Settings, params.generators[name], f"params.yaml: train_generator.generators.{name}")


def _examples(plugin: type[Learned], settings: Any, scenarios: Path, workers: int) -> tuple[Any, Any]:
    """What the generator learns from and what it is validated on, shard by shard."""
    train, validation = spread_splits(
        _shard_examples, scenarios, lambda split: [(plugin, settings, shard) for shard in shards(split)], workers, "scenes"
    )
    return plugin.Examples.joined(train), plugin.Examples.joined(validation)


def _shard_examples(task: tuple[type[Learned], Any, Path]) -> Any:
    plugin, settings, shard = task
    return plugin.examples(settings, read_shard(shard))


def _scores(generator: Learned, split: Path, params: Params, told_log: bool = False) -> dict[str, float]:
    """Displacement errors [m] of `samples` futures of every validation scenario, the mean over scenarios."""
    found = []
    for shard in shards(split):
        logged = [s for s in read_shard(shard) if s.log is not None]
        shown = logged if told_log else [first_frame(s) for s in logged]
        for scenario, made in zip(logged, generator.generate(shown, params.samples, params.training_seed), strict=True):
            assert scenario.log is not None
            try:
                found.append(summarise(*scene_errors(made.motion, scenario.log)))
            except UnusableInput as error:
                if error.reason != "nothing-to-score":
                    raise
    names = ("min_sade", "min_sfde", "mean_sade", "mean_sfde")
    return {f"validation_{n}": float(np.mean([getattr(one, n) for one in found])) for n in names} if found else {}


if __name__ == "__main__":
    enter("train_generator", Params, main)
