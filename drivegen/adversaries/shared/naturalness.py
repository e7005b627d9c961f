"""How natural is what an adversary lets vehicles do: their odds under a generator that has no part in making the traffic."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories


class LikelihoodModel(Protocol):
    """A generator that can say how likely it would have been to make given traffic."""

    def log_likelihood(self, scenarios: Sequence[Scenario], traffic: Sequence[Trajectories]) -> list[NDArray[np.float64]]:
        """(N,) [nat] of each vehicle's motion in each scenario's `traffic` (N, T), in units that the generator states.

        NaN for who is never there. What others do is known as it happens.
        """


def exchanged(before: Trajectories, after: Trajectories) -> NDArray[np.int64]:
    """Vehicles of traffic (N, T) that move otherwise in the other."""
    differs = (before.valid != after.valid) | (before.valid & (before.position != after.position).any(-1))
    return np.flatnonzero(differs.any(-1)).astype(np.int64)


def naturalness(
    judge: LikelihoodModel, scenarios: Sequence[Scenario], before: Sequence[Trajectories], after: Sequence[Trajectories]
) -> NDArray[np.float64]:
    """(S, 2) log likelihood of the exchanged vehicles, mean over them: as they move in `after` (S,) and did `before`.

    In the unit of `judge`; NaN where nobody moves otherwise, or nobody who does is there long enough, both times, to be judged.
    """
    found = np.full((len(scenarios), 2), np.nan)
    odds = zip(judge.log_likelihood(scenarios, after), judge.log_likelihood(scenarios, before), strict=True)
    for s, both in enumerate(odds):
        of_exchanged = np.column_stack(both)[exchanged(before[s], after[s])]
        known = of_exchanged[np.isfinite(of_exchanged).all(1)]
        if len(known):
            found[s] = known.mean(0)
    return found
