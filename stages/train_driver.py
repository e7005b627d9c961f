"""Stage train_driver@<driver>: teach a driver on the train split's logs; its weights are those that drive best on the val split.

argv: scenarios (folder with train and val), model (folder; its name is the driver's), metrics (JSON), what it learned (CSV).
"""

import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.lessons import Lessons, Taught, write_grades
from drivegen.drivers.shared.network import write_network
from drivegen.drivers.shared.policy import ACTIVATION
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards
from stages._door import build, enter, require


@dataclass(frozen=True)
class Params:
    """`drivers`: how each is taught, by its name, as its `lessons_type` says."""

    training_seed: int
    drivers: dict[str, Any]


def main(params: Params, scenarios: Path, model: Path, metrics: Path, curve: Path) -> dict[str, float]:
    """Teach, save, say how it drives."""
    name = model.name
    plugin = plugins.load("drivers", name)
    if not issubclass(plugin, Taught):
        raise UnusableInput(f"driver {name!r} learns nothing: take it out of run.taught_drivers in params.yaml")
    if name not in params.drivers:
        raise UnusableInput(f"params.yaml: train_driver.drivers has no settings for {name!r}")
    how = build(plugin.lessons_type(), params.drivers[name], f"params.yaml: train_driver.drivers.{name}")
    train, validation = (_lessons(require(scenarios / split, "run the ingest stage")) for split in ("train", "val"))
    began = time.process_time()
    policy, grades = plugin.teach(
        how, train, validation, params.training_seed, partial(print, f"train_driver {name}:", flush=True)
    )
    took = time.process_time() - began
    write_network(model, name, policy.linear, ACTIVATION, squashed=False)
    write_grades(curve, grades)
    kept = min(reversed(grades[1:]), key=lambda grade: grade.badness)
    counts = {"train_scenes": len(train), "validation_scenes": len(validation)}
    write_json(metrics, {"driver": name, **counts, **{f"validation_{key}": value for key, value in asdict(kept).items()}})
    return {"training_cpu_seconds": took}


def _lessons(folder: Path) -> Lessons:
    scenarios = [scenario for shard in shards(folder) for scenario in read_shard(shard) if scenario.log is not None]
    if not scenarios:
        raise UnusableInput(f"{folder} holds no scenario with a log to learn from", reason="no-scenarios")
    return Lessons.of(scenarios, [scenario.log for scenario in scenarios if scenario.log is not None])


if __name__ == "__main__":
    enter("train_driver", Params, main)
