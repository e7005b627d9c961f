"""DriveGen-CS with two attackers: first single goals, then pairs of them in one scene, those that rank best together.

A driver that brakes for one may be met by the other. Both keep the rules, towards each other, too.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries import drivegen_cs
from drivegen.adversaries.base import About
from drivegen.adversaries.shared.arena import Arena
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.rules import RULES
from drivegen.adversaries.shared.sources import Goals
from drivegen.core.settings import Count
from drivegen.corner_cases.trials import Variants

ABOUT = About(
    title="DriveGen-CS, two attackers",
    traffic="generated",
    varies="goals",
    source="Zhang and others, DriveGen (2025)",
    proposer="gap and warning, as DriveGen-CS has it, of two together",
)


@dataclass(frozen=True)
class Settings(drivegen_cs.Ranking):
    """Beside those of the ranking.

    Attributes:
        goals: what is ranked.
        alone: rounds of `learn_after` runs with one attacker before the pairs.
        best: vehicles of each scene of whose best candidates pairs are made.
    """

    goals: Goals
    alone: Count
    best: Count


class Plugin(drivegen_cs.Ranked):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings, settings.goals)
        self._alone, self._best = settings.alone, settings.best

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        pool, cost = self.one_by_one(arena, self._alone)
        pairs = sorted(_pairs(pool, cost, self._best), key=lambda pair: (float(cost[list(pair)].sum()), pair))
        chosen = np.array(_first_allowed(arena, pool, pairs), np.int64).reshape(-1, 2)
        first, both = chosen[:, 0], chosen.ravel()
        rows = np.repeat(np.arange(len(chosen)), 2)
        variants = Variants(pool.scene[first], pool.vehicle[first], rows, pool.vehicle[both], pool.motion[both])
        arena.drive(variants, pool.odds[chosen].prod(axis=1))


def _pairs(pool: Candidates, cost: NDArray[np.floating], best: int) -> Iterator[tuple[int, int]]:
    """Of each scene, all pairs of the cheapest candidates of its `best` cheapest vehicles."""
    order = np.argsort(cost, kind="stable")
    order = order[np.isfinite(cost[order])]
    for s in np.unique(pool.scene).tolist():
        mine = order[pool.scene[order] == s]
        _, first = np.unique(pool.vehicle[mine], return_index=True)
        yield from combinations(mine[np.sort(first)][:best].tolist(), 2)


def _first_allowed(arena: Arena, pool: Candidates, pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The first pairs that the arena allows together, as many in each scenario as runs are left there."""
    room, chosen = arena.left.copy(), []
    for pair in pairs:
        both = np.array(pair)
        s = int(pool.scene[both[0]])
        c = int(arena.ground.of[s])
        if room[c] > 0 and not arena.violation(s, pool.vehicle[both], pool.motion[both]) & RULES[arena.bounds.allowed]:
            room[c] -= 1
            chosen.append(pair)
    return chosen
