"""Stage train_generator@<rival>: train a generator to compare with on the train split's logs, then score it on the val split.

It learns from every log and its twin (`core.twins`), as DriveGen's goal selector does. While it trains it is rolled out on
a few validation scenes, the same for all, half of them as twins: the weights of the least error are kept. `plateau` of the
metrics says whether the last third of the training gained nothing there; `watched` names the scenes. Then the temperature that
it draws by, where it has one, is chosen on some more of them, from a list that is the same for all: `HEADLINE` is what counts.

argv: scenarios (folder with train and val), model (folder; its name is the generator's), metrics (JSON), loss curve (CSV).
An interrupted training goes on from `.drivegen/checkpoints/`, in a folder named after everything that it depends on.
"""

import shutil
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count, Positive
from drivegen.core.twins import twin
from drivegen.generators.shared.learned import Learned
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards
from drivegen.training import checkpoint
from drivegen.training.curve import kept, plateau, write_curve
from drivegen.training.timing import timed
from stages._door import build, learnt_from
from stages._rolled_out import Watched, scores_of

CHECKPOINTS = Path(".drivegen/checkpoints")

HEADLINE = ("min_sade", "mean_sade", "energy_joint")
"""The errors [m] that the tables tell first: a temperature is good by their sum, as sharper odds trade one for another."""


@dataclass(frozen=True)
class Params:
    """What all learned generators share, and the settings of each.

    Attributes:
        samples: futures of each validation scenario behind the metrics.
        watched: scenes and futures of each that are rolled out on the way.
        temperatures: of which each generator that has one gets the best; the first where there is nothing to choose by.
        tuned: scenes and futures of each that are rolled out at each of these.
        generators: settings by name, as the generator's `Settings` says.
    """

    training_seed: int
    workers: Count
    samples: Count
    watched: Watched
    temperatures: tuple[Positive, ...]
    tuned: Watched
    generators: dict[str, Any]


def main(params: Params, scenarios: Path, model: Path, metrics: Path, curve: Path) -> dict[str, float]:
    """Train, save, score."""
    seed, (plugin, settings) = params.training_seed, _chosen(model.name, params)
    train, validation = _examples(plugin, settings, scenarios, params.workers)
    inputs = (model.name, asdict(settings), seed, params.watched)
    data = [*shards(scenarios / "train"), *shards(scenarios / "val")]
    checkpoints = CHECKPOINTS / checkpoint.name_of(inputs, data, checkpoint.source_digest("drivegen", "stages"))
    say = partial(print, f"train_generator {model.name}:", flush=True)
    watched, tuned = (drawn.of(scenarios / "val") for drawn in (params.watched, params.tuned))

    def error(model_so_far: Learned) -> float:
        return params.watched.errors(model_so_far, watched).get("min_sade", float("nan"))

    costs: dict[str, float] = {}
    with timed("training", costs):
        generator, rows = plugin.fit(settings, train, validation, seed, checkpoints, say, error)
    with timed("tuning", costs):
        tried = generator.tune(params.temperatures, lambda made: params.tuned.errors(made, tuned), HEADLINE)
    generator.save(model)
    write_curve(curve, rows, error="min_sade")
    counts = {"train_examples": len(train), "validation_examples": len(validation), "steps": rows[-1].step}
    best, names = kept(rows), [scenario.scenario_id for scenario in watched]
    learnt = {"parameters": generator.parameters, "kept_step": best.step, "validation_loss": best.validation}
    watch = {"plateau": plateau(rows), "watched": names, "tried": {f"{t:g}": errors for t, errors in tried.items()}}
    chosen = {"sampling_temperature": float(generator.temperature)} if tried else {}
    scores = {f"validation_{key}": value for key, value in scores_of(generator, scenarios / "val", params.samples, seed).items()}
    for bound, with_log in generator.bounds().items():
        errors = scores_of(with_log, scenarios / "val", params.samples, seed, told_log=True)
        scores |= {f"{bound}.validation_{key}": value for key, value in errors.items()}
    write_json(metrics, {"generator": model.name, **counts, **learnt, **watch, **chosen, **scores})
    shutil.rmtree(checkpoints, ignore_errors=True)
    return {**{key: float(value) for key, value in counts.items()}, **costs}


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

    def tasks(split: Path) -> list[tuple[type[Learned], Any, Path]]:
        return [(plugin, settings, shard) for shard in shards(split)]

    return learnt_from(plugin.Examples, _shard_examples, scenarios, tasks, workers, "scenes")


def _shard_examples(task: tuple[type[Learned], Any, Path]) -> Any:
    plugin, settings, shard = task
    return plugin.examples(settings, [seen for log in read_shard(shard) for seen in (log, twin(log))])
