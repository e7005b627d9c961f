"""Which goals the vehicles of a scenario try: first those drawn for all of them together, then the likeliest that are left."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.scenario import Trajectories
from drivegen.goals.joint import PENALTY, SWEEPS, draw_together, gumbel, in_tempo, orders, tempos
from drivegen.goals.outlook import Outlooks
from drivegen.rollout.choices import Choices

FAILED = 3.0
"""Each failed trajectory makes its goal exp(3), 20 times, less likely to be tried again."""


class GoalDraws:
    """Goals of N vehicles in K samples; Q candidates of all vehicles stand one below the other.

    Attributes:
        first: (K, N) the goals that all begin with, counted within each vehicle's candidates.
    """

    def __init__(
        self,
        choice: Choices,
        target_steps: NDArray[np.int64],
        samples: int,
        seed: int,
        *,
        exclusion: bool,
        tempo: float,
    ) -> None:
        """`target_steps` (N,) as `Outlooks` has them; `exclusion` and `tempo` as `RolloutSettings`."""
        name, used = choice.scenario.scenario_id, np.concatenate(choice.used)
        self._outlooks = Outlooks.of(choice.scenario, choice.candidates, target_steps)
        self._start = self._outlooks.start
        noise = gumbel(seed, name, samples, len(used))
        with np.errstate(divide="ignore"):
            self._score = np.log(used.astype(np.float64)) + noise[0]
        self._failed = np.zeros((samples, len(used)), np.int64)
        exclusive = self._outlooks.exclusions() if exclusion else np.zeros((len(used),) * 2, np.bool_)
        order = orders(seeds.rng(seed, "order", name), SWEEPS, samples, len(self._start) - 1)
        odds: NDArray[np.floating] = used
        if tempo > 0:  # own odds to the bit where vehicles have nothing in common
            odds = in_tempo(used, self._start, self._outlooks.distance, tempos(seed, name, samples), tempo)
        self.first = draw_together(odds, self._start, exclusive, noise, order)

    def fail(self, sample: int, vehicle: int, goals: NDArray[np.int64]) -> None:
        """None of the trajectories towards `goals` was legal; a goal may be among them more than once."""
        np.add.at(self._failed[sample], self._start[vehicle] + goals, 1)

    def next_goals(self, sample: int, vehicle: int, committed: Trajectories, size: NDArray[np.float32], count: int) -> list[int]:
        """The `count` goals to try next, the likeliest first; a goal may be tried more than once.

        `committed` (N, T) is what the others drive in this sample, `size` (N, 2) [m] all vehicles'.
        """
        own = slice(self._start[vehicle], self._start[vehicle + 1])
        met = self._outlooks.meetings(vehicle, committed, size)
        score = self._score[sample, own] - PENALTY * met - FAILED * self._failed[sample, own]
        chosen = []
        for _ in range(count):
            best = int(np.argmax(score))
            chosen.append(best)
            score[best] -= FAILED
        return chosen
