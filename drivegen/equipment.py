"""What generation needs of the folder of trained models: a planner, a goal selector, the checker's limits."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import orjson

from drivegen import plugins
from drivegen.checker.limits import Limits
from drivegen.errors import MissingTool, UnusableInput
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


def read_limits(models: Path) -> Limits:
    """The checker's limits, `models/limits.json`; raises MissingTool where it is absent, UnusableInput where it is broken."""
    path = models / "limits.json"
    if not path.exists():
        raise MissingTool(f"{path} is not there: `make run` calibrates it and trains the models beside it")
    try:
        values = orjson.loads(path.read_bytes())
    except orjson.JSONDecodeError:
        raise UnusableInput(f"{path} is not JSON: remove it and `make run` again") from None
    return Limits.from_json(values, str(path))
