"""Stage train_driver@<driver>: teach a driver on the train split's logs; its weights are those that drive best on the val split.

argv: scenarios (folder with train and val), model (folder; its name is the driver's), metrics (JSON), what it learned (CSV).
An interrupted training goes on from `.drivegen/checkpoints/`, in a file named after everything that it depends on.
"""

import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.lessons import Lessons, write_grades
from drivegen.drivers.shared.teaching import Taught, teach
from drivegen.store.files import write_json
from drivegen.store.lookup import logs_below
from drivegen.store.scenarios import shards
from drivegen.training import checkpoint
from stages._door import build, require

CHECKPOINTS = Path(".drivegen/checkpoints")


@dataclass(frozen=True)
class Params:
    """`drivers`: how each is taught, by its name, as its `lessons_type` says."""

    training_seed: int
    drivers: dict[str, Any]


def main(params: Params, scenarios: Path, model: Path, metrics: Path, curve: Path) -> dict[str, float]:
    """Teach, save, say how it drives."""
    name = model.name
    plugin, how = _chosen(name, params)
    folders = [require(scenarios / split, "run the ingest stage") for split in ("train", "val")]
    train, validation = (Lessons.of(logs_below(folder)) for folder in folders)
    data = [shard for folder in folders for shard in shards(folder)]
    inputs, code = (name, how, params.training_seed), checkpoint.source_digest("drivegen", "stages")
    path = CHECKPOINTS / f"{checkpoint.name_of(inputs, data, code)}.safetensors"
    began = time.process_time()
    pupil = plugin.pupil(how, train, params.training_seed)
    say = partial(print, f"train_driver {name}:", flush=True)
    policy, grades = teach(pupil, how.course, validation, params.training_seed, path, say)
    took = time.process_time() - began
    policy.write(model, name)
    write_grades(curve, grades)
    best = min(reversed(grades[1:]), key=lambda grade: grade.badness)
    counts = {"train_scenes": len(train), "validation_scenes": len(validation)}
    write_json(metrics, {"driver": name, **counts, **{f"validation_{key}": value for key, value in asdict(best).items()}})
    path.unlink(missing_ok=True)
    return {"training_cpu_seconds": took}


def _chosen(name: str, params: Params) -> tuple[type[Taught], Any]:
    """The driver called `name` and how it is taught; raises UnusableInput where it learns nothing or params do not say how."""
    plugin = plugins.load("drivers", name)
    if not issubclass(plugin, Taught):
        raise UnusableInput(f"driver {name!r} learns nothing: take it out of run.taught_drivers in params.yaml")
    if name not in params.drivers:
        raise UnusableInput(f"params.yaml: train_driver.drivers has no settings for {name!r}")
    return plugin, build(plugin.lessons_type(), params.drivers[name], f"params.yaml: train_driver.drivers.{name}")
