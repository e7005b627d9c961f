"""Stage tune@<driver>-<seed>: a driver is taught on logs, then tuned from there on each method's scenes, for as long on each.

argv: scenarios (folder of splits), tuning scenes (a folder a method), more futures of DriveGen (folder of shards), models,
recorded goals of one selector, samples in which corner cases are looked for (folder of shards), policies (folder
<driver>/<seed>, gets the weights of each row, `dataset` and `dataset_longer` among them), how they did on the way (JSON).
Stops are chosen on the val split. Tuning scenes, futures and corner cases are of the test split.
"""

from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.settings import Count
from drivegen.drivers.shared.lessons import Lessons
from drivegen.drivers.shared.tuning import How, Say, Tuner
from drivegen.store.files import write_json
from drivegen.store.lookup import logs_below
from stages._door import require
from stages._lessons import CornerCases, Rows, Sources

BASE, LONGER = "dataset", "dataset_longer"


@dataclass(frozen=True)
class Further:
    """Seeds after so many tune on the scenes of these methods alone."""

    after: Count
    methods: tuple[str, ...]


@dataclass(frozen=True)
class Params:
    """`methods`: on whose scenes drivers are tuned. `drivers`: how each is taught (`base`), and tuned (`tuned`).

    `seeds` of policies; dvc.yaml makes a stage of each. `amounts`: so many futures of each scene are added to its log.
    """

    seeds: tuple[int, ...]
    further: Further
    methods: tuple[str, ...]
    amounts: tuple[Count, ...]
    corner_cases: CornerCases
    drivers: dict[str, dict[str, Any]]

    def rows(self, seed: int) -> Rows:
        """Those of a policy seed."""
        if seed in self.seeds[self.further.after :]:
            return Rows(tuple(method for method in self.methods if method in self.further.methods), (), None)
        return Rows(self.methods, self.amounts, self.corner_cases if self.corner_cases.share else None)


def main(
    params: Params,
    scenarios: Path,
    scenes: Path,
    futures: Path,
    models: Path,
    goals: Path,
    traffic: Path,
    out: Path,
    metrics: Path,
) -> None:
    """The base policy, then one policy for each row, all from the same base."""
    name, seed = out.parent.name, int(out.name)
    plugin, how = plugins.load("drivers", name), How.of(name, params.drivers, "tune.drivers")
    folders = [require(scenarios / split, "run the ingest stage") for split in ("train", "val")]
    train, validation = (Lessons.of(logs_below(folder)) for folder in folders)

    def say(row: str) -> Say:
        return partial(print, f"tune {name} {seed} {row}:", flush=True)

    tuner = Tuner(plugin, how, train, validation, seed, say(BASE))
    tuner.base.write(out / BASE, name)
    driver = plugin(plugin.settings_type(weights=str(out / BASE), sees_rules=True))
    sources = Sources(scenarios / "test", scenes, futures, models, goals, traffic)
    rows = ((row, Lessons.of(driven)) for row, driven in sources.of(params.rows(seed), driver, seed))
    grades = {BASE: [asdict(grade) for grade in tuner.grades]}
    for row, lessons in chain([(LONGER, train)], rows):
        policy, looked = tuner.tune(lessons, say(row))
        policy.write(out / row, name)
        grades[row] = [asdict(grade) for grade in looked]
    write_json(metrics, grades)
