"""What drivers are tuned on, row by row: a method's scenes, logs with more and more futures, scenes with corner cases."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from drivegen.adversaries.base import Adversary
from drivegen.adversaries.shared.arena import Bounds
from drivegen.adversaries.shared.repair import attacked, found_cases, lessons_of, whole
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count, Index, Within, file_of
from drivegen.drivers.base import Driver
from drivegen.drivers.shared.conditions import Traffic
from drivegen.drivers.shared.tuning import mixed
from drivegen.store.lookup import first_futures, logs_below
from drivegen.store.scenarios import shards
from drivegen.world.reactive import Reaction
from stages._door import require
from stages._ground import Made

LOGS, OURS = "log", "drivegen"
"""To whose scenes futures are added, and among whose the cases are."""

AMOUNT, CASES, SHOWN = "amount_", "corner_cases", "careful_teacher"
"""Rows beside those of methods; of amounts with the number behind it. In the last one the teacher of the corner cases shows how
to drive in as many scenes without an attack: what of the cases' worth is the teacher's."""


@dataclass(frozen=True)
class CornerCases:
    """How corner cases are looked for to learn from.

    Attributes:
        share: of the lessons that are cases (0: none). adversaries: who looks for them, and its settings. teacher: who shows how
            to drive in them, and its settings. planner, allowed, reaction_steps: as in `attack`. samples: scenes of each
            scenario; `queries` runs in these. reaction: of neighbours.
    """

    share: Annotated[float, Within(0, 0.9)]
    adversaries: dict[str, dict[str, Any]]
    teacher: dict[str, dict[str, Any]]
    planner: str
    samples: Count
    allowed: str
    queries: Count
    reaction_steps: Index
    reaction: Reaction

    @property
    def bounds(self) -> Bounds:
        """Of what may be proposed, and how often the driver is run."""
        return Bounds(self.allowed, self.queries, self.reaction_steps)

    def searching(self, section: str) -> dict[str, Adversary]:
        """The adversaries; `section` is that of these settings."""
        place = f"{section}.adversaries"
        return {name: plugins.make("adversaries", name, self.adversaries, place) for name in self.adversaries}

    def shown_by(self, section: str) -> Driver:
        """Who teaches. Raises UnusableInput unless it is one."""
        if len(self.teacher) != 1:
            raise UnusableInput(f"{file_of(section)}: {section}.teacher names one driver, not {len(self.teacher)}")
        [name] = self.teacher
        driver: Driver = plugins.make("drivers", name, self.teacher, f"{section}.teacher")
        return driver


@dataclass(frozen=True)
class Rows:
    """Which rows there are beside those of logs; see `stages.tune.Params`."""

    methods: tuple[str, ...]
    amounts: tuple[int, ...]
    corner_cases: CornerCases | None


@dataclass(frozen=True)
class Sources:
    """Folders that lessons come from: see the stage `tune`; `test` is the split that tuning scenes were made of."""

    test: Path
    scenes: Path
    futures: Path
    models: Path
    goals: Path
    traffic: Path

    def tuning(self, method: str) -> list[Traffic]:
        """The tuning scenes of a method."""
        return logs_below(require(self.scenes / method, f"run the stage tune_traffic with {method!r} among tune.methods"))

    def cases(self, how: CornerCases, driver: Driver, seed: int) -> list[Traffic]:
        """What adversaries find against `driver`, as far as it shows how to drive."""
        made = Made.open(self.models, how.planner, self.goals, self.traffic)
        who, cases = how.searching("tune.corner_cases"), list[Traffic]()
        for shard in shards(self.test):
            ground = whole(made.choices(shard), made.samples(shard), how.samples, made.planner, made.limits)
            cases += found_cases(attacked(driver, ground, who, how.bounds, seed, how.reaction))
        return lessons_of(cases, how.shown_by("tune.corner_cases"))

    def of(self, rows: Rows, driver: Driver, seed: int) -> Iterator[tuple[str, list[Traffic]]]:
        """Each row with its lessons; corner cases are those of `driver`."""
        for method in rows.methods:
            yield method, self.tuning(method)
        for amount in rows.amounts:
            yield f"{AMOUNT}{amount}", [*self.tuning(LOGS), *first_futures(self.futures, self.test, amount)]
        if (how := rows.corner_cases) is not None:
            cases = self.cases(how, driver, seed)
            print(f"tune {driver.name} {seed} {CASES}: {len(cases)} cases to learn from", flush=True)
            yield CASES, mixed(self.tuning(OURS), cases, how.share)
            shown = lessons_of(self.tuning(OURS), how.shown_by("tune.corner_cases"))
            yield SHOWN, mixed(self.tuning(OURS), shown, how.share)
