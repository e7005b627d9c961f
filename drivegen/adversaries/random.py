"""Random goals: one vehicle takes another of its goals, all alike, as if nothing were known.

A scenario in which no goal is allowed is driven as it is, once.
"""

import numpy as np

from drivegen.adversaries.base import About
from drivegen.adversaries.shared.arena import Arena, share_out
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.goals import exchanged_goals
from drivegen.adversaries.shared.settings import WithoutSettings
from drivegen.core import seeds
from drivegen.corner_cases.trials import Variants

ABOUT = About(title="random goals", traffic="generated", varies="goals", source="none", proposer="chance")


class Plugin(WithoutSettings):
    """See the module."""

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        drive_at_random(exchanged_goals(arena, 1, np.arange(len(arena.ground.of))), arena)


def drive_at_random(pool: Candidates, arena: Arena) -> None:
    """Spend the budget on candidates drawn from the `pool`, all alike; a scenario that has none is driven as it is, once."""
    luck = np.empty(len(pool))
    scenario = arena.ground.of[pool.scene]
    for c, choice in enumerate(arena.ground.choices):
        mine = np.flatnonzero(scenario == c)
        luck[mine] = seeds.rng(arena.seed, "random goals", choice.scenario.scenario_id).random(len(mine))
    pool.drive(arena, np.argsort(luck, kind="stable"), arena.bounds.budget)
    idle = share_out(arena.ground.of, (arena.spent == 0).astype(np.int64))
    arena.drive(Variants.unchanged(idle, arena.trials.steps))
