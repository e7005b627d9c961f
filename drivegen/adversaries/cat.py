"""CAT: the goal whose natural odds times its overlap with the driver's last motions are highest (Zhang and others, CoRL 2023).

    argmax over goals g of  P(g) * sum over the last motions of DECAY ^ t(g, motion),

t being the first step at which the boxes overlap; a goal that never does is worth P(g) * APART / (1 + its gap in metres) instead.
In the paper a network (DenseTNT) gives 32 futures of one opponent with their odds; here these are the project's own candidates,
odds and planner, for every vehicle. The authors' code looks at every fifth step, so DECAY is that of 0.5 s, here of 0.1 s; where
none overlaps, it takes the nearest whatever its odds. Each run adds one of the driver's motions; what was driven is not driven
again.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import About
from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Arena, everywhere, share_out
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.sources import Goals, Source
from drivegen.core.scenario import Trajectories
from drivegen.core.settings import Count
from drivegen.corner_cases.trials import Variants

ABOUT = About(
    title="CAT",
    traffic="generated",
    varies="goals",
    source="Zhang and others, CAT, CoRL 2023",
    proposer="overlap, as CAT has it",
    stand_in="its choice among the project's goals, with their odds and planner, instead of DenseTNT's futures",
)

DECAY = 0.99
"""An overlap a step later is worth so much less."""

APART = 1e-6
"""What never overlaps is worth this at most, times its odds."""


@dataclass(frozen=True)
class Choosing:
    """How it chooses.

    Attributes:
        per_scene: runs for which one more scene is attacked.
        last: motions of the driver that are looked at.
    """

    per_scene: Count
    last: Count


@dataclass(frozen=True)
class Settings(Choosing):
    """`goals`: what is chosen from."""

    goals: Goals


class Chooser:
    """Chooses from a source by odds and overlap."""

    def __init__(self, settings: Choosing, source: Source) -> None:
        self.settings, self.source = settings, source

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        ground = arena.ground
        scenes = share_out(ground.of, np.maximum(arena.left // self.settings.per_scene, 1))
        motion = arena.drive(Variants.unchanged(scenes, arena.trials.steps)).motion
        pool = self.source.candidates(arena, scenes)
        worth = _overlap(arena, pool, everywhere(motion, scenes, len(ground.of))) * _odds(pool)
        pool = self.source.varied(arena, pool, np.argsort(-worth, kind="stable"))
        overlaps, odds = np.zeros((self.settings.last, len(pool))), _odds(pool)
        turn, tried = 0, np.zeros(len(pool), np.bool_)
        while True:
            driven = np.isin(pool.scene, scenes)
            overlaps[turn % len(overlaps), driven] = _overlap(arena, pool, everywhere(motion, scenes, len(ground.of)))[driven]
            untried = np.flatnonzero(~tried)
            order = untried[np.argsort(-(odds * overlaps.sum(0))[untried], kind="stable")]
            rows, outcome = pool.drive(arena, order, 1)
            if not len(rows):
                return
            tried[rows], scenes, motion, turn = True, pool.scene[rows], outcome.motion, turn + 1


class Plugin(Chooser):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings, settings.goals)


def _odds(pool: Candidates) -> NDArray[np.float32]:
    """(Q,) natural odds; what has none is all alike."""
    return np.where(np.isnan(pool.odds), np.float32(1.0), pool.odds)


def _overlap(arena: Arena, pool: Candidates, driven: Trajectories) -> NDArray[np.float64]:
    """(Q,) what a candidate is worth by the first step at which its box overlaps that of a target as it drove."""
    met = approaches(arena.trials, driven, pool.scene, pool.vehicle, pool.motion)
    return np.where(met.contact >= 0, DECAY ** met.contact.astype(np.float64), APART / (1 + met.gap))
