"""CAT: the goal whose natural odds times its overlap with the driver's last motions are highest (Zhang and others, CoRL 2023).

    argmax over goals g of  P(g) * sum over the last motions of DECAY ^ (t(g, motion) / EVERY),

t being the first step at which the boxes overlap; of goals that never do the nearest comes first, whatever its odds. In the
paper a network (DenseTNT) gives 32 futures of one opponent with their odds; here these are the project's own candidates, odds and
planner, for every vehicle. Each run adds one of the driver's motions; what was driven is not driven again.
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

DECAY, EVERY = 0.99, 5
"""An overlap EVERY steps later is worth DECAY as much: the authors' code looks at every fifth step."""


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
        motion = arena.drive(Variants.unchanged(scenes, arena.trials.steps)).to_the_end
        pool = self.source.candidates(arena, scenes)
        overlap, gap = _nearness(arena, pool, everywhere(motion, scenes, len(ground.of)))
        pool = self.source.varied(arena, pool, _ranked(_odds(pool) * overlap, gap))
        overlaps, gaps = np.zeros((self.settings.last, len(pool))), np.full((self.settings.last, len(pool)), np.inf)
        runs, tried = np.zeros(len(ground.of), np.int64), np.zeros(len(pool), np.bool_)
        while True:
            driven = np.flatnonzero(np.isin(pool.scene, scenes))
            at = runs[pool.scene[driven]] % self.settings.last
            overlap, gap = _nearness(arena, pool, everywhere(motion, scenes, len(ground.of)))
            overlaps[at, driven], gaps[at, driven] = overlap[driven], gap[driven]
            order = _ranked(_odds(pool) * overlaps.sum(0), gaps.min(0))
            rows, outcome = pool.drive(arena, order[~tried[order]], 1)
            if not len(rows):
                return
            runs[scenes] += 1
            tried[rows], scenes, motion = True, pool.scene[rows], outcome.to_the_end


class Plugin(Chooser):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings, settings.goals)


def _odds(pool: Candidates) -> NDArray[np.float32]:
    """(Q,) natural odds; what has none is all alike."""
    return np.where(np.isnan(pool.odds), np.float32(1.0), pool.odds)


def _nearness(arena: Arena, pool: Candidates, driven: Trajectories) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """(Q,) what a candidate's overlap with a target as it drove is worth, 0 where there is none, and (Q,) its gap to it [m]."""
    met = approaches(arena.trials, driven, pool.scene, pool.vehicle, pool.motion)
    return np.where(met.contact >= 0, DECAY ** (met.contact // EVERY).astype(np.float64), 0.0), met.gap


def _ranked(worth: NDArray[np.floating], gap: NDArray[np.floating]) -> NDArray[np.intp]:
    """(Q,) candidates from the best on: by what they are worth, and those that are worth nothing by their gaps."""
    return np.lexsort((np.where(worth > 0, 0.0, gap), -worth))
