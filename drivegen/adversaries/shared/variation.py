"""Variations of the best goals: the same vehicle gets a little farther or less far, arrives faster or slower, more to one side.

A goal is one place with one speed; who is to meet a driver has to be in its way at the right moment. So the goals that come
nearest to the driver are planned again towards many places near them. Each of these plans is there once more, shifted across on
its way (`shared.shift`): another time and place of a change of lane. What comes of both is judged and ranked as goals are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Arena, Ground
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.goals import hurried
from drivegen.adversaries.shared.shift import Shift
from drivegen.core import seeds
from drivegen.core.scenario import Trajectories
from drivegen.core.settings import Count, Index
from drivegen.rollout.towards import Spread, plan_near_goals
from drivegen.simulators.shared.drives import numbered

METRES = 2.0
"""A goal that is faster by 1 m/s is as far away as one so many metres farther on."""


@dataclass(frozen=True)
class Variation:
    """`best`: so many goals of each scene are varied, none for 0, `times` each. `spread`: of the places around them. `shift`."""

    best: Index
    times: Count
    spread: Spread
    shift: Shift


def with_variations(arena: Arena, pool: Candidates, order: NDArray[np.integer], variation: Variation) -> Candidates:
    """The pool and behind it, of the first candidates of each scene in `order`, all variations that the arena allows.

    Variations have the natural odds of the goal that is nearest to where they end. Candidates that are no goals are not varied.
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
    planned = plan_near_goals(ground.choices, of_scenario, variation.spread, hurried(ground.planner), seed)
    ids = [choice.scenario.scenario_id for choice in ground.choices]
    motion, planned_as = _with_shifts(planned, variation.shift, [seeds.rng(arena.seed, "shifts", name) for name in ids])
    rows = rows[planned_as]
    kept = np.flatnonzero(arena.allows(pool.scene[rows], pool.vehicle[rows], motion))
    rows, motion = rows[kept], motion[kept]
    odds = odds_of_nearest(ground, pool.scene[rows], pool.vehicle[rows], motion)
    varied = Candidates(pool.scene[rows], pool.vehicle[rows], pool.goal[rows], odds, motion)
    return Candidates.joined([pool, varied])


def _with_shifts(
    planned: Sequence[Trajectories], shift: Shift, streams: Sequence[np.random.Generator]
) -> tuple[Trajectories, NDArray[np.int64]]:
    """All tracks (E, T) of all scenarios, then those that are there throughout once more, shifted; and (F,) which is which's."""
    there = [np.flatnonzero(motion.valid.all(1) & (shift.most > 0)) for motion in planned]
    moved = [shift.draw(motion[rows], random) for motion, rows, random in zip(planned, there, streams, strict=True)]
    first = np.cumsum([0, *(len(motion.valid) for motion in planned)])
    again = [low + rows for low, rows in zip(first[:-1], there, strict=True)]
    return Trajectories.joined([*planned, *moved]), np.concatenate([np.arange(first[-1]), *again])


def odds_of_nearest(
    ground: Ground, scene: NDArray[np.integer], vehicle: NDArray[np.integer], motion: Trajectories
) -> NDArray[np.float32]:
    """(E,) natural odds of the goal nearest to where each track (E, T) of a vehicle (E,) of a scene (E,) ends.

    Goals are apart by their places and, METRES for each m/s, by their speeds.
    """
    odds, scenario, row = np.empty(len(scene), np.float32), ground.of[scene], np.arange(len(scene))
    last = motion.last_valid()
    end = np.column_stack([motion.position[row, last], METRES * motion.speed[row, last]])
    for c, n in np.unique(np.column_stack([scenario, vehicle]), axis=0).tolist():
        mine, goals = np.flatnonzero((scenario == c) & (vehicle == n)), ground.choices[c].candidates[n]
        places = np.column_stack([goals.position, METRES * goals.speed])
        nearest = np.linalg.norm(end[mine, None] - places, axis=-1).argmin(axis=1)
        odds[mine] = ground.choices[c].natural[n][nearest]
    return odds
