"""The natural law of traffic around a target, which says how often something happens in it; `scene` only makes traffic.

p(c_1 .. c_M) ~ prod_n p_n(c_n) * exp(-PENALTY * pairs that exclude each other), over the goals of all vehicles but the target,
where the motions towards them, one for every goal, are legal together and beside the target's own plan; else p = 0. It is drawn
by Gibbs sweeps (`goals.joint`) from a start of each draw's own, and a scene in which anybody is illegal is rejected as a whole:
nobody is planned again, moved aside or left out of a draw, so draws are independent and follow the law. There is no tempo. The
law is of who is there, which callers take from one earlier future: whoever stayed illegal in that is in none of the draws.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.goals.joint import draw_together, orders
from drivegen.goals.outlook import Outlooks
from drivegen.rollout.choices import Choices

SWEEPS = 8
"""How often every vehicle draws again, given the others, before a draw is taken."""

BLOCK = 256
"""So many draws are made and judged at once."""


@dataclass(frozen=True)
class NaturalLaw:
    """The law of one scene of N vehicles, of which M draw among Q goals.

    Attributes:
        traffic: (N, T) in which only the target's motion stays. vehicle: (M,) int64 who draws.
        start: (M + 1,) int64 rows of each one's goals. odds: (Q,) float32 of each vehicle's own. motion: (Q, T) towards each.
        exclusive: (Q, Q) bool, which goals exclude each other.
    """

    checker: SceneChecker
    traffic: Trajectories
    vehicle: NDArray[np.int64]
    start: NDArray[np.int64]
    odds: NDArray[np.float32]
    motion: Trajectories
    exclusive: NDArray[np.bool_]

    @classmethod
    def of(cls, choice: Choices, traffic: Trajectories, planned: Trajectories, limits: Limits) -> Self:
        """Of a scene's `traffic` (N, T), which says who is there and what the target plans; `planned` (C, T), `plan_all_goals`.

        A goal whose motion is illegal by itself is nobody's; a vehicle without any other is not there.
        """
        checker, scenario = SceneChecker(choice.scenario, limits), choice.scenario
        owner = np.repeat(np.arange(len(choice.candidates)), [len(each) for each in choice.candidates])
        odds = np.concatenate(choice.natural)
        rows = np.flatnonzero(traffic.valid[owner, 0] & (owner != TARGET) & (odds > 0))
        rows = rows[checker.alone(owner[rows], planned[rows]).violation == 0]
        vehicle, start = np.unique(owner[rows], return_index=True)
        outlooks = Outlooks.of(scenario, choice.candidates, np.full(len(choice.candidates), scenario.steps))
        exclusive = outlooks.exclusions()[np.ix_(rows, rows)]
        return cls(checker, traffic, vehicle, np.append(start, len(rows)).astype(np.int64), odds[rows], planned[rows], exclusive)

    def draw(self, wanted: int, most: int, random: np.random.Generator) -> NDArray[np.int64]:
        """(D, M) rows of `motion`: the first `wanted` legal ones of about `most` draws, fewer where these hold no more."""
        if not len(self.vehicle):
            return np.zeros((wanted if self.legal(np.zeros((1, 0), np.int64))[0] else 0, 0), np.int64)
        kept, count = list[NDArray[np.int64]](), 0
        for _ in range(-(-most // BLOCK)):
            noise = random.gumbel(size=(SWEEPS + 1, BLOCK, len(self.odds))).astype(np.float32)
            order = orders(random, SWEEPS, BLOCK, len(self.vehicle))
            rows = self.start[:-1] + draw_together(self.odds, self.start, self.exclusive, noise, order)
            kept.append(rows[self.legal(rows)])
            count += len(kept[-1])
            if count >= wanted:
                break
        return np.concatenate(kept)[:wanted]

    def legal(self, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(K,) whether all are legal in each of K scenes of goals (K, M)."""
        scenes = self.scenes(rows)
        violation, _ = self.checker.check_samples(scenes)
        return np.asarray((violation == 0).all(axis=1))

    def scenes(self, rows: NDArray[np.int64]) -> Trajectories:
        """Everybody's motion (K, N, T) by goals (K, M)."""
        whole = Trajectories.empty(len(rows), *self.traffic.valid.shape)
        whole.put((slice(None), TARGET), self.traffic[TARGET])
        whole.put((slice(None), self.vehicle), self.motion[rows])
        return whole
