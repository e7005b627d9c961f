"""The log itself, K times: the reference row of every table, and the anchor that a metric must score as perfect."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drivegen.core.errors import UnusableInput
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario

ABOUT = Method(
    title="Log (recorded futures)",
    line="The recorded futures, repeated.",
    kind="bound",
    goals=None,
    trains_on="nothing",
    places=False,
    additions=(),
)


class Plugin:
    """Repeats the log; the only generator that may look at it."""

    backend = "recorded"
    about = ABOUT

    def __init__(self, models: Path, settings: object) -> None:
        """Needs neither models nor settings."""
        del models, settings

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K copies of each log. Raises UnusableInput for a scenario without one."""
        del seed
        return [self._repeat(scenario, samples) for scenario in scenarios]

    def _repeat(self, scenario: Scenario, samples: int) -> Samples:
        if scenario.log is None:
            raise UnusableInput(f"scenario {scenario.scenario_id} was never recorded: `log` has nothing to repeat")
        copies = scenario.log[np.newaxis][np.zeros(samples, np.intp)]
        return Samples.without_goals(scenario.scenario_id, "log", copies)
