"""What an adversary chooses from: single vehicles' tracks, each of which may be exchanged for what the vehicle does now."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Arena
from drivegen.core.scenario import Trajectories
from drivegen.corner_cases.trials import Variants
from drivegen.world.outcome import DrivingOutcome


@dataclass(frozen=True)
class Candidates:
    """Q tracks that the arena allows.

    Attributes:
        scene: (Q,) int64. vehicle: (Q,) int64 whose track it is. goal: (Q,) int64 number of its goal among the vehicle's, -1
            where it has none. odds: (Q,) float32 natural odds of that goal, else NaN. motion: (Q, T).
    """

    scene: NDArray[np.int64]
    vehicle: NDArray[np.int64]
    goal: NDArray[np.int64]
    odds: NDArray[np.float32]
    motion: Trajectories

    @classmethod
    def joined(cls, parts: "Sequence[Candidates]") -> Self:
        """All parts in order; at least one."""
        return cls(
            np.concatenate([part.scene for part in parts]),
            np.concatenate([part.vehicle for part in parts]),
            np.concatenate([part.goal for part in parts]),
            np.concatenate([part.odds for part in parts]),
            Trajectories.joined([part.motion for part in parts]),
        )

    def __len__(self) -> int:
        return len(self.scene)

    def __getitem__(self, rows: slice) -> "Candidates":
        return Candidates(self.scene[rows], self.vehicle[rows], self.goal[rows], self.odds[rows], self.motion[rows])

    def drive(self, arena: Arena, order: NDArray[np.integer], most: int) -> tuple[NDArray[np.int64], DrivingOutcome]:
        """Drive the first of `order` that fit, `most` in each scenario: which (V,), and what became of them."""
        rows = arena.first_allowed(self.scene, self.vehicle, self.motion, order, most)
        chosen = Variants.one_each(self.scene[rows], self.vehicle[rows], self.motion[rows])
        return rows, arena.drive(chosen, self.odds[rows])
