"""The belief that candidates were spread by, nothing learned: what the learned selector has to beat."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.base import FirstFrameSelector, Untrained


class Plugin(Untrained, FirstFrameSelector):
    """The prior mass that each candidate stands for (see `goals/prior.py`)."""

    described = "hand-made prior"

    def rank(
        self,
        graph: LaneGraph,  # noqa: ARG002 protocol
        scenario: Scenario,  # noqa: ARG002 protocol
        candidates: Sequence[Candidates],
    ) -> list[NDArray[np.float32]]:
        """The prior."""
        return [c.prior for c in candidates]
