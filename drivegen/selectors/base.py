"""The protocol of a goal selector: give each vehicle's candidate goals probabilities (paper: goals ranked by likelihood)."""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.roads.graph import LaneGraph


class Selector(Protocol):
    """Ranks candidates. `Plugin.load(folder)` opens a selector; one that learned nothing ignores the folder.

    Attributes:
        described: who chose, in words, as it stands in every table.
        reads_log: whether it is told what happened, as only bounds are.
    """

    described: str
    reads_log: bool

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Raises MissingTool, with the remedy, where weights are needed and absent."""

    def offer(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[Candidates]:
        """The candidates of all vehicles that `rank` is to be asked about: the given ones, perhaps with more at the end."""

    def rank(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[NDArray[np.float32]]:
        """Probabilities (C,), summing to 1, for each vehicle's candidates; from the map and the first frame.

        A vehicle's result does not depend on which scenario was ranked before. Only the `log` selector looks at the log.
        """


class FirstFrameSelector:
    """What selectors have in common that see the first frame alone: they rank exactly what they are given."""

    reads_log = False

    def offer(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[Candidates]:  # noqa: ARG002 protocol
        """The given candidates."""
        return list(candidates)


class Untrained:
    """What selectors have in common that learned nothing."""

    @classmethod
    def load(cls, folder: Path) -> Self:  # noqa: ARG003 protocol
        """A new one."""
        return cls()
