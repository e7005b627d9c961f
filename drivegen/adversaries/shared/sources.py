"""What adversaries choose from: goals, with variations of the best, or perturbed tracks."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Arena
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.goals import exchanged_goals
from drivegen.adversaries.shared.motions import Perturbation, exchanged_motions
from drivegen.adversaries.shared.variation import Variation, with_variations
from drivegen.core.settings import Count


class Source(Protocol):
    """Where candidates come from."""

    def candidates(self, arena: Arena, scenes: NDArray[np.int64]) -> Candidates:
        """What may be exchanged in `scenes`."""

    def varied(self, arena: Arena, pool: Candidates, order: NDArray[np.integer]) -> Candidates:
        """The pool, and what is added to it near the first of `order`."""


@dataclass(frozen=True)
class Goals:
    """`draws`: motions towards each goal. `variation`: of the goals that are best at first."""

    draws: Count
    variation: Variation

    def candidates(self, arena: Arena, scenes: NDArray[np.int64]) -> Candidates:
        """See `Source`."""
        return exchanged_goals(arena, self.draws, scenes)

    def varied(self, arena: Arena, pool: Candidates, order: NDArray[np.integer]) -> Candidates:
        """See `Source`."""
        return with_variations(arena, pool, order, self.variation)


@dataclass(frozen=True)
class Motions:
    """`draws`: perturbed tracks for each goal that a vehicle has. `perturbation`: of them."""

    draws: Count
    perturbation: Perturbation

    def candidates(self, arena: Arena, scenes: NDArray[np.int64]) -> Candidates:
        """See `Source`."""
        return exchanged_motions(arena, self.perturbation, self.draws, scenes)

    def varied(self, arena: Arena, pool: Candidates, order: NDArray[np.integer]) -> Candidates:  # noqa: ARG002
        """The pool alone: more tracks like these are more draws."""
        return pool
