"""DriveGen itself: goals from the learned selector, motion from the planner, everything checked (paper, section III)."""

from collections.abc import Sequence
from pathlib import Path

from drivegen.equipment import Equipment
from drivegen.generate import choose, roll_out
from drivegen.generators.base import Settings
from drivegen.rollout import Choices
from drivegen.samples import Samples
from drivegen.scenario import Scenario


class Plugin:
    """DriveGen; its ablations differ by the selector alone."""

    name = "drivegen"
    selector = "learned"

    def __init__(self, models: Path, settings: Settings) -> None:
        """Raises MissingTool where weights or limits are absent."""
        self._equipment = Equipment.open(models, settings.planner, self.selector)
        self._settings = settings
        self.backend = self._equipment.selector.described

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` judged futures of each scenario, goals chosen here."""
        chosen = choose(scenarios, self._equipment.selector, self._settings.candidates, self._settings.temperature)
        return self.follow(chosen, samples, seed)

    def follow(self, choices: Sequence[Choices], samples: int, seed: int) -> list[Samples]:
        """K = `samples` judged futures of each scenario, goals chosen before."""
        tools, settings = self._equipment, self._settings
        return roll_out(choices, tools.planner, tools.limits, settings.rollout, samples, seed, self.name)
