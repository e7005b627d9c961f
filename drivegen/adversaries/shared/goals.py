"""Goals of single vehicles, exchanged: every candidate goal of every social vehicle, planned, and judged in each scene."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Arena, social
from drivegen.core import seeds
from drivegen.core.scenario import Trajectories
from drivegen.corner_cases.trials import Variants
from drivegen.rollout.batch import plan_all_goals
from drivegen.world.outcome import DrivingOutcome


@dataclass(frozen=True)
class Goals:
    """Q exchanged goals that are allowed.

    Attributes:
        scene: (Q,) int64. vehicle: (Q,) int64 who takes it. odds: (Q,) float32 natural odds of it. motion: (Q, T).
    """

    scene: NDArray[np.int64]
    vehicle: NDArray[np.int64]
    odds: NDArray[np.float32]
    motion: Trajectories

    @classmethod
    def allowed(cls, arena: Arena, draws: int, scenes: NDArray[np.int64] | None = None) -> "Goals":
        """All that the arena allows in `scenes` (all of them where not given), `draws` motions towards each.

        A motion is the same in all scenes of its scenario.
        """
        scenes = np.arange(len(arena.ground.of)) if scenes is None else scenes
        asked = ("goals", draws, *scenes.tolist())
        if asked not in arena.made:
            streams = [seeds.derive(arena.seed, "exchanged goals", d) for d in range(draws)]
            arena.made[asked] = cls._joined([cls._planned(arena, scenes, stream) for stream in streams])
        made: Goals = arena.made[asked]
        return made

    @classmethod
    def _joined(cls, parts: "Sequence[Goals]") -> "Goals":
        return cls(
            np.concatenate([part.scene for part in parts]),
            np.concatenate([part.vehicle for part in parts]),
            np.concatenate([part.odds for part in parts]),
            Trajectories.joined([part.motion for part in parts]),
        )

    @classmethod
    def _planned(cls, arena: Arena, scenes: NDArray[np.int64], seed: int) -> "Goals":
        ground = arena.ground
        planned = plan_all_goals(ground.choices, ground.planner, seed)
        steps, found = max(motion.steps for motion in planned), []
        for s, c in zip(scenes.tolist(), ground.of[scenes].tolist(), strict=True):
            choice = ground.choices[c]
            owner = np.repeat(np.arange(len(choice.candidates)), [len(each) for each in choice.candidates])
            rows = np.flatnonzero(np.isin(owner, social(ground.traffic[s])))
            scene, odds = np.full(len(rows), s), np.concatenate(choice.natural)
            kept = arena.allows(scene, owner[rows], planned[c][rows])
            found.append(cls(scene[kept], owner[rows][kept], odds[rows][kept], padded(planned[c][rows[kept]], steps)))
        return cls._joined(found)

    def __len__(self) -> int:
        return len(self.scene)

    def drive(self, arena: Arena, order: NDArray[np.integer], most: int) -> tuple[NDArray[np.int64], DrivingOutcome]:
        """Drive the first of `order` that fit, `most` in each scenario: which (V,), and what became of them."""
        rows = arena.first_allowed(self.scene, self.vehicle, self.motion, order, most)
        chosen = Variants.one_each(self.scene[rows], self.vehicle[rows], self.motion[rows])
        return rows, arena.drive(chosen, self.odds[rows])


def padded(motion: Trajectories, steps: int) -> Trajectories:
    """The motion (E, T) with `steps` steps, not valid after its own."""
    whole = Trajectories.empty(len(motion.valid), steps)
    for name in ("position", "heading", "velocity", "valid"):
        getattr(whole, name)[:, : motion.steps] = getattr(motion, name)
    return whole
