"""The protocol of a generator: map and initial states in, K futures of every vehicle out.

A generator may read a scenario's map, vehicles, signals and context actors, never its log (`log` is the one stated
exception: it is the reference row). Signals hold the states that will be shown over the whole horizon: they are control that
is given, as the map is, and a scenario that is made has a program for them. `Plugin(models, settings)` opens what it needs
below the folder of trained models.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.rejected import Rejections
from drivegen.rollout import RolloutSettings
from drivegen.samples import Samples
from drivegen.scenario import Scenario
from drivegen.settings import Positive
from drivegen.store.goals import GoalColumns


@dataclass(frozen=True)
class Settings:
    """How traffic is generated.

    Attributes:
        planner: name of the planner that fills in motion.
        candidates: how candidate goals are made.
        temperature: below 1 the likely goals gain, above 1 the unlikely ones (`generate.tempered`).
        rollout: how often the illegal is planned again, and what becomes of what stays illegal.
    """

    planner: str
    candidates: CandidateSettings
    temperature: Positive
    rollout: RolloutSettings


class Generator(Protocol):
    """Makes K futures of each scenario, not yet judged by the checker where `selector` is None.

    Attributes:
        backend: who chose the goals, in words, for the tables ("learned selector", "uniform", "none").
        selector: the goal selector whose recorded goals it can follow (`GoalFollower`), None if it knows no goals.
    """

    backend: str
    selector: str | None

    def __init__(self, models: Path, settings: Settings) -> None:
        """Raises MissingTool where trained weights are needed and absent."""

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` futures per scenario, in order; a result depends on its scenario and the seed alone."""


class GoalFollower(Generator, Protocol):
    """A generator that can follow goals which a stage before it recorded."""

    def follow(
        self,
        scenarios: Sequence[Scenario],
        goals: Sequence[GoalColumns],
        samples: int,
        seed: int,
        rejections: Mapping[str, Rejections] | None = None,
    ) -> list[Samples]:
        """K = `samples` judged futures of each scenario by the odds of `goals`, in order.

        `rejections`, by scenario, are told what the checker turned down on the way; they change nothing.
        """
