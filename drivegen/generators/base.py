"""The protocol of a generator: map and initial states in, K futures of every vehicle out.

A generator may read a scenario's map, vehicles, signals and context actors, never its log (`log` is the one stated
exception: it is the reference row). A log is regenerated from what `core.first_frame` leaves of it: signals at step 0 (later
UNKNOWN: drivers take the last known state to last, the checker sees no red) and context actors where they are assumed to be.
A scenario that is made holds its signals' program and its context as they will be played. `Plugin(models, settings)` opens
what it needs below the folder of trained models. `ABOUT = Method(...)` in the same file says what it is, in literals: see
`core.methods`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Protocol

from drivegen.core.methods import Method
from drivegen.core.rejections import Rejections
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Within
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.rollout.scene import RolloutSettings
from drivegen.store.goals import GoalColumns


@dataclass(frozen=True)
class Settings:
    """How traffic is generated.

    Attributes:
        planner: name of the planner that fills in motion.
        candidates: how candidate goals are made.
        temperature: below 1 the likely goals gain, above 1 the unlikely ones (`rollout.choices.tempered`). Below 0.01 a power of
            it would round the odds of all goals to nought.
        rollout: how often the illegal is planned again, and what becomes of what stays illegal.
    """

    planner: str
    candidates: CandidateSettings
    temperature: Annotated[float, Within(0.01)]
    rollout: RolloutSettings


class Generator(Protocol):
    """Makes K futures of each scenario, not yet judged by the checker where `selector` is None.

    Attributes:
        about: what it says of itself, the ABOUT of its file; one that names `goals` can follow them (`GoalFollower`).
        backend: who chose the goals, in words, for the tables ("learned selector", "uniform", "none").
    """

    about: Method
    backend: str

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
