"""LCTGen told what every vehicle will do: the action fields of its code from the log. An upper bound, no method."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.errors import UnusableInput
from drivegen.generators import lctgen
from drivegen.generators._lctgen.codes import Action, logged_actions
from drivegen.generators._vectors import Scenes
from drivegen.scenario import Scenario


class Plugin(lctgen.Plugin):
    """As `lctgen`, with its weights; looks at the log, and says so."""

    backend = "recorded"

    @property
    def said(self) -> str:
        """See `lctgen`."""
        return "lctgen_log_code"

    def known_actions(self, scenarios: Sequence[Scenario]) -> NDArray[np.int64]:
        """The log's actions; KEEP_SPEED where it did not see any. Raises UnusableInput for a scenario without a log."""
        for scenario in scenarios:
            if scenario.log is None:
                raise UnusableInput(f"scenario {scenario.scenario_id} was never recorded: there is no action to take from it")
        actions, seen = logged_actions(Scenes.with_logs(scenarios).padded(lctgen.CHUNK))
        return np.where(seen, actions, Action.KEEP_SPEED)
