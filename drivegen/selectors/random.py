"""Every candidate is as likely as any other: the paper's ablation without goal selection ("w/o gs")."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.base import FirstFrameSelector, Untrained


class Plugin(Untrained, FirstFrameSelector):
    """Uniform over the candidates."""

    described = "random choice"

    def rank(
        self,
        graph: LaneGraph,  # noqa: ARG002 protocol
        scenario: Scenario,  # noqa: ARG002 protocol
        candidates: Sequence[Candidates],
    ) -> list[NDArray[np.float32]]:
        """1 / C each."""
        return [np.full(len(c), 1 / len(c), np.float32) for c in candidates]
