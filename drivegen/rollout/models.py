"""What generation needs of the folder of trained models: a planner, a goal selector, the checker's limits."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

from drivegen.checker.limits import Limits
from drivegen.checker.verdicts import read_limits
from drivegen.core import plugins
from drivegen.planners.base import Planner
from drivegen.selectors.base import Selector


@dataclass(frozen=True)
class Equipment:
    """Everything learned or calibrated that a rollout uses."""

    planner: Planner
    selector: Selector
    limits: Limits

    @classmethod
    def open(cls, models: Path, planner: str, selector: str) -> Self:
        """Read `models/planners/<planner>`, `models/selector` and `models/limits.json`.

        Raises MissingTool, with the remedy, where one is absent.
        """
        return cls(
            planner=read_planner(models, planner),
            selector=plugins.load("selectors", selector).load(models / "selector"),
            limits=read_limits(models),
        )


def read_planner(models: Path, name: str) -> Planner:
    """The trained planner `models/planners/<name>`; raises MissingTool where it is absent."""
    planner: Planner = plugins.load("planners", name).load(models / "planners" / name)
    return planner
