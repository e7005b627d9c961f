"""DriveGen itself: goals from the learned selector, motion from the planner, everything checked (paper, section III)."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from drivegen.core.methods import Method
from drivegen.core.rejections import Rejections
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.generators.base import Settings
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import Choices, choose, recorded_choices
from drivegen.rollout.models import Equipment
from drivegen.store.goals import GoalColumns

ABOUT = Method(
    title="DriveGen",
    line="Goals by the learned selector, motion towards them by the planner, everything checked and planned again.",
    kind="ours",
    goals="learned",
    trains_on="the logs",
    places=False,
    additions=("exclusion", "checker", "tempo"),
)


class Plugin:
    """DriveGen; its ablations differ by `about.goals` alone."""

    name = "drivegen"
    about = ABOUT

    def __init__(self, models: Path, settings: Settings) -> None:
        """Raises MissingTool where weights or limits are absent."""
        assert self.about.goals is not None
        self._equipment = Equipment.open(models, settings.planner, self.about.goals)
        self._settings = settings
        self.backend = self._equipment.selector.described

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` judged futures of each scenario, goals chosen here."""
        settings = self._settings
        return self._rolled(choose(scenarios, self._equipment.selector, settings.candidates, settings.temperature), samples, seed)

    def follow(
        self,
        scenarios: Sequence[Scenario],
        goals: Sequence[GoalColumns],
        samples: int,
        seed: int,
        rejections: Mapping[str, Rejections] | None = None,
    ) -> list[Samples]:
        """K = `samples` judged futures of each scenario by the odds recorded for it; see `GoalFollower.follow`."""
        return self._rolled(recorded_choices(scenarios, goals, self._settings.temperature), samples, seed, rejections)

    def _rolled(
        self, choices: Sequence[Choices], samples: int, seed: int, rejections: Mapping[str, Rejections] | None = None
    ) -> list[Samples]:
        tools, rollout = self._equipment, self._settings.rollout
        return roll_out(choices, tools.planner, tools.limits, rollout, samples, seed, self.name, rejections=rejections)
