"""One round of corner cases, shard by shard: read, lean on the goals, play, write, and say what it taught."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen.checker.verdicts import read_limits
from drivegen.core.errors import MissingTool
from drivegen.core.settings import Count
from drivegen.corner_cases.asking import endanger
from drivegen.corner_cases.collisions import Collision, collisions
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.pressure import PressureSettings
from drivegen.corner_cases.round_folder import RoundFolder
from drivegen.corner_cases.rounds import lean_on, learn, play
from drivegen.corner_cases.summary import RoundSummary, summarise
from drivegen.drivers.base import Driver
from drivegen.generators.base import Settings
from drivegen.planners.base import Planner
from drivegen.questions.account import Account
from drivegen.questions.asking import Asking
from drivegen.rollout.choices import Choices, recorded_choices
from drivegen.rollout.models import read_planner
from drivegen.simulators.base import Simulator
from drivegen.store.goals import read_goals
from drivegen.store.scenarios import read_shard


@dataclass(frozen=True)
class RoundSettings:
    """How a round is played.

    Attributes:
        samples: futures of each scenario. generation, pressure: see their classes.
    """

    seed: int
    samples: Count
    generation: Settings
    pressure: PressureSettings


@dataclass(frozen=True)
class Played:
    """What a shard of a round came to: what its encounters alone taught, its numbers, its collisions."""

    knowledge: Knowledge
    summary: RoundSummary
    collisions: Sequence[Collision]


@dataclass(frozen=True)
class Round:
    """What all shards of a round have in common. Where nobody is asked it can be sent to other processes.

    Attributes:
        folder: that is written. models: folder of trained models. goals: folder of recorded goals, a file a shard.
        driver: under test. simulator: that runs it.
        knowledge: what the rounds before taught.
        asking: who is asked about goals, None where nobody is. account: of what was asked and answered.
    """

    folder: RoundFolder
    models: Path
    goals: Path
    driver: Driver
    simulator: Simulator
    settings: RoundSettings
    knowledge: Knowledge
    asking: Asking | None
    account: Account

    def choices(self, shard: Path) -> list[Choices]:
        """The goals among which vehicles of a shard's scenarios choose, with the selector's recorded odds.

        Raises MissingTool where none are recorded, UnusableInput where they are those of other scenarios.
        """
        recorded = self.goals / shard.name
        if not recorded.exists():
            raise MissingTool(f"{recorded} is not there: run the goals stage")
        return recorded_choices(read_shard(shard), read_goals(recorded), self.settings.generation.temperature)

    def play(self, shard: Path) -> Played:
        """Generate and drive the scenarios of a shard, and write samples and driven targets.

        Round 0 leans on nothing. Raises MissingTool where models, recorded goals or the round before are not there.
        """
        settings, choices = self.settings, self.choices(shard)
        planner, limits = read_planner(self.models, settings.generation.planner), read_limits(self.models)
        if self.folder.number > 0:
            choices = self._leaning(shard, choices, planner)
        rollout = settings.generation.rollout
        drives = play(choices, planner, limits, rollout, self.driver, self.simulator, settings.samples, settings.seed)
        self.folder.write_drives(shard.name, drives)
        taught = learn(Knowledge.none(self.knowledge.strength), drives, choices, settings.pressure.reach)
        hits = [hit for choice, drive in zip(choices, drives, strict=True) for hit in collisions(choice, drive)]
        return Played(taught, summarise(choices, drives), hits)

    def goals_by(self) -> dict[str, Any]:
        """For tables: who leans on the goals of social vehicles, and where a model is asked the account of it."""
        if self.asking is None:
            return {"goals": "statistical re-weighting"}
        return {"goals": self.asking.model.description, "asking": self.account.table()}

    def _leaning(self, shard: Path, choices: list[Choices], planner: Planner) -> list[Choices]:
        """Choices under pressure of the knowledge, for a target that drives as it did in the round before."""
        expected = self.folder.before.driven(shard.name)
        leaning = lean_on(choices, expected, planner, self.knowledge, self.settings.pressure, self.settings.seed)
        if self.asking is None:
            return leaning
        return endanger(choices, leaning, self.asking, self.settings.pressure.max_ratio, self.account)
