"""The protocol of a generator: map and initial states in, K futures of every vehicle out.

A generator may read a scenario's map, vehicles, signals and context actors, never its log (`log` is the one stated
exception: it is the reference row). `Plugin(models, settings)` opens what it needs below the folder of trained models.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from drivegen.samples import Samples
from drivegen.scenario import Scenario


@dataclass(frozen=True)
class Settings:
    """How traffic is generated.

    Attributes:
        planner: name of the planner that fills in motion.
        selector: name of the goal selector.
        temperature: goals are drawn from `p ** (1 / temperature)`, normalised.
        attempts: trajectories planned per round for a vehicle whose last ones were illegal.
        rounds: how often the illegal are planned again; each round moves on to further goals.
        drop_illegal: leave out what could not be made legal (shipped scenarios), or keep the least illegal (tables).
        ignore_target: leave the target out of the collision check (corner cases: its driver has to react).
    """

    planner: str
    selector: str
    temperature: float
    attempts: int
    rounds: int
    drop_illegal: bool
    ignore_target: bool


class Generator(Protocol):
    """Makes K futures of each scenario.

    Attributes:
        backend: who chose the goals, in words, for the tables ("learned selector", "uniform", "none").
    """

    backend: str

    def __init__(self, models: Path, settings: Settings) -> None:
        """Raises MissingTool where trained weights are needed and absent."""

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` futures per scenario, in order; a result depends on its scenario and the seed alone."""
