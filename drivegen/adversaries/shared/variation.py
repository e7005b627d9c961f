"""Variations of the best goals: the same vehicle gets a little farther or less far, arrives faster or slower, more to one side.

A goal is one place with one speed; who is to meet a driver has to be in its way at the right moment. So the goals that come
nearest to the driver are planned again towards many places near them, and what comes of that is judged and ranked as goals are.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Arena
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.core import seeds
from drivegen.core.scenario import Trajectories
from drivegen.core.settings import Count, Index
from drivegen.rollout.towards import Spread, plan_near_goals
from drivegen.simulators.shared.drives import numbered


@dataclass(frozen=True)
class Variation:
    """`best`: so many goals of each scene are varied, none for 0, `times` each. `spread`: of the places around them."""

    best: Index
    times: Count
    spread: Spread


def with_variations(arena: Arena, pool: Candidates, order: NDArray[np.integer], variation: Variation) -> Candidates:
    """The pool and behind it, of the first candidates of each scene in `order`, all variations that the arena allows.

    Variations have the natural odds of the goal that they are varied from. Candidates that are no goals are not varied.
    """
    order = order[pool.goal[order] >= 0]
    goals = np.column_stack([pool.scene, pool.vehicle, pool.goal])[order]
    order = order[np.sort(np.unique(goals, axis=0, return_index=True)[1])]  # several motions towards a goal are one goal
    best = order[numbered(pool.scene[order]) < variation.best]
    if not len(best):
        return pool
    ground = arena.ground
    best = best[np.lexsort((best, pool.scene[best]))]
    rows = np.repeat(best, variation.times)
    number, zero = np.tile(np.arange(variation.times), len(best)), np.zeros(len(rows), np.int64)
    digits = np.column_stack([number, pool.vehicle[rows], pool.goal[rows], zero])
    scenario = ground.of[pool.scene[rows]]  # rises, as scenes do: motion comes scenario by scenario
    of_scenario = [digits[scenario == c] for c in range(len(ground.choices))]
    seed = seeds.derive(arena.seed, "variations")
    planned = plan_near_goals(ground.choices, of_scenario, variation.spread, ground.planner, seed)
    steps = max(pool.motion.steps, *(motion.steps for motion in planned))
    motion = Trajectories.joined([part.padded(steps) for part in planned])
    kept = np.flatnonzero(arena.allows(pool.scene[rows], pool.vehicle[rows], motion))
    rows = rows[kept]
    varied = Candidates(pool.scene[rows], pool.vehicle[rows], pool.goal[rows], pool.odds[rows], motion[kept])
    return Candidates.joined([pool.padded(steps), varied])
