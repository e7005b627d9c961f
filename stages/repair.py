"""Stage repair@<driver>: a driver goes on learning with its corner cases among the logs; then it is attacked again, elsewhere.

argv: scenarios (folder of splits), models, recorded goals of one selector, samples that are the traffic (folder of shards),
policies (folder; gets the weights of each version), what became of each version (JSON, a list of rows).
Cases come from the test split: of each half of its recordings, for who is tested in the other half.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from drivegen.adversaries.shared.findings import Findings
from drivegen.adversaries.shared.repair import (
    BEFORE,
    LONGER,
    REPAIRED,
    Half,
    attacked,
    found_cases,
    halved,
    lessons_of,
    repair_rows,
)
from drivegen.core import plugins
from drivegen.core.samples import Samples
from drivegen.core.settings import Count
from drivegen.drivers.base import Driver
from drivegen.drivers.shared.conditions import Traffic
from drivegen.drivers.shared.lessons import Lessons
from drivegen.drivers.shared.policy import Policy
from drivegen.drivers.shared.tuning import How, Say, Tuner, mixed
from drivegen.rollout.choices import Choices
from drivegen.store.files import write_json
from drivegen.store.lookup import logs_below
from drivegen.store.scenarios import shards
from stages._door import require
from stages._ground import Made
from stages._lessons import CornerCases


@dataclass(frozen=True)
class Params(CornerCases):
    """`drivers`: how each is taught (`base`), and tuned (`tuned`). Adversaries test, too; those that search find the cases."""

    seed: int
    drivers: dict[str, dict[str, Any]]
    draws: Count


def main(params: Params, scenarios: Path, models: Path, goals: Path, traffic: Path, out: Path, results: Path) -> None:
    """Teach, attack, teach with what was found, attack again."""
    both, pupil = _halved(params, scenarios / "test", models, goals, traffic), _Pupil(params, scenarios, out)
    who, seed = params.searching("repair"), params.seed

    def tested(*drivers: Driver) -> list[dict[str, Findings]]:
        return [attacked(d, half, who, params.bounds, seed, params.reaction) for d, half in zip(drivers, both, strict=True)]

    before = tested(pupil.before, pupil.before)
    cases = [lessons_of(found_cases(half), params.shown_by("repair")) for half in before]
    longer = pupil.tuned(LONGER, pupil.logs)
    tests = {BEFORE: before, LONGER: tested(longer, longer), REPAIRED: tested(*(pupil.repaired(n, cases[1 - n]) for n in (0, 1)))}
    write_json(results, list(repair_rows(tests, sum(map(len, cases)), params.draws, params.seed)))


class _Pupil:
    """The driver named by the folder `out`, in which its versions are written; `before` was taught on `logs`."""

    def __init__(self, params: Params, scenarios: Path, out: Path) -> None:
        self._share, self._out, self._plugin = params.share, out, plugins.load("drivers", out.name)
        train, val = (require(scenarios / split, "run the ingest stage") for split in ("train", "val"))
        self.logs, validation = Lessons.of(logs_below(train)), Lessons.of(logs_below(val))
        how = How.of(out.name, params.drivers, "repair.drivers")
        self._tuner = Tuner(self._plugin, how, self.logs, validation, params.seed, self._say(BEFORE))
        self.before = self._driver(BEFORE, self._tuner.base)

    def tuned(self, version: str, lessons: Lessons) -> Driver:
        """On these for as long as on any others."""
        return self._driver(version, self._tuner.tune(lessons, self._say(version))[0])

    def repaired(self, half: int, cases: Sequence[Traffic]) -> Driver:
        """For one half of the recordings, by `cases` of the other."""
        version, traffic = f"{REPAIRED}_{half}", mixed(self.logs.traffic, cases, self._share)
        self._say(version)(f"{len(cases)} cases are {1 - len(self.logs) / len(traffic):.0%} of its lessons")
        return self.tuned(version, Lessons.of(traffic))

    def _driver(self, version: str, policy: Policy) -> Driver:
        policy.write(self._out / version, self._out.name)
        made: Driver = self._plugin(self._plugin.settings_type(weights=str(self._out / version), sees_rules=True))
        return made

    def _say(self, version: str) -> Say:
        return partial(print, f"repair {self._out.name} {version}:", flush=True)


def _halved(params: Params, split: Path, models: Path, goals: Path, traffic: Path) -> list[Half]:
    made = Made.open(models, params.planner, goals, traffic)
    choices, samples = list[Choices](), list[Samples]()
    for shard in shards(require(split, "run the ingest stage")):
        choices += made.choices(shard)
        samples += made.samples(shard)
    return halved(choices, samples, params.samples, made.planner, made.limits, params.seed)
