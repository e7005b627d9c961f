"""Stage tune@<driver>-<seed>: a driver is taught on logs, then tuned from there on each method's scenes, for as long on each.

argv: scenarios (folder with train and val), tuning scenes (a folder a method), policies (folder <driver>/<seed>, gets the
weights of each row, `dataset` and `dataset_longer` among them), how they did on the way (JSON).
Stops are chosen on the val split.
"""

from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.drivers.shared.lessons import Lessons
from drivegen.drivers.shared.tuning import How, Say, Tuner
from drivegen.store.files import write_json
from drivegen.store.lookup import logs_below
from stages._door import enter, require

BASE, LONGER = "dataset", "dataset_longer"


@dataclass(frozen=True)
class Params:
    """`methods`: on whose scenes drivers are tuned. `drivers`: how each is taught (`base`), and tuned (`tuned`).

    `seeds` of policies; dvc.yaml makes a stage of each.
    """

    seeds: tuple[int, ...]
    methods: tuple[str, ...]
    drivers: dict[str, dict[str, Any]]


def main(params: Params, scenarios: Path, scenes: Path, out: Path, metrics: Path) -> None:
    """The base policy, then one policy for each method, all from the same base."""
    name, seed = out.parent.name, int(out.name)
    how = How.of(name, params.drivers, "tune.drivers")
    folders = [require(scenarios / split, "run the ingest stage") for split in ("train", "val")]
    train, validation = (Lessons.of(logs_below(folder)) for folder in folders)

    def say(row: str) -> Say:
        return partial(print, f"tune {name} {seed} {row}:", flush=True)

    tuner = Tuner(plugins.load("drivers", name), how, train, validation, seed, say(BASE))
    tuner.base.write(out / BASE, name)
    grades = {BASE: [asdict(grade) for grade in tuner.grades]}
    for row in (LONGER, *params.methods):
        lessons = train if row == LONGER else Lessons.of(logs_below(require(scenes / row, "run the stage tune_traffic")))
        policy, looked = tuner.tune(lessons, say(row))
        policy.write(out / row, name)
        grades[row] = [asdict(grade) for grade in looked]
    write_json(metrics, grades)


if __name__ == "__main__":
    enter("tune", Params, main)
