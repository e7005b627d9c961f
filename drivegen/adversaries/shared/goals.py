"""Candidates that are goals: every goal of every social vehicle, planned, and judged in each scene."""

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Arena, social
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.core import seeds
from drivegen.planners.base import Planner
from drivegen.planners.shared.flow_planner import FlowPlanner
from drivegen.rollout.towards import plan_all_goals

EULER_STEPS = 2
"""Of a planner by flow when it plans for adversaries, instead of generation's eight: they want many motions and not their
spread, and find about as much in three quarters of the time (LOG.md)."""


def hurried(planner: Planner) -> Planner:
    """The planner as adversaries ask it."""
    return planner.in_steps(EULER_STEPS) if isinstance(planner, FlowPlanner) else planner


def exchanged_goals(arena: Arena, draws: int, scenes: NDArray[np.int64]) -> Candidates:
    """All that the arena allows in `scenes`, `draws` motions towards each goal, the same in all scenes of a scenario."""
    asked = ("goals", draws, *scenes.tolist())
    if asked not in arena.made:
        streams = [seeds.derive(arena.seed, "exchanged goals", d) for d in range(draws)]
        arena.made[asked] = Candidates.joined([_planned(arena, scenes, stream) for stream in streams])
    made: Candidates = arena.made[asked]
    return made


def _planned(arena: Arena, scenes: NDArray[np.int64], seed: int) -> Candidates:
    ground = arena.ground
    planned = plan_all_goals(ground.choices, hurried(ground.planner), seed)
    steps, found = max(motion.steps for motion in planned), []
    for s, c in zip(scenes.tolist(), ground.of[scenes].tolist(), strict=True):
        choice = ground.choices[c]
        owner = np.repeat(np.arange(len(choice.candidates)), [len(each) for each in choice.candidates])
        goal = np.concatenate([np.arange(len(each)) for each in choice.candidates])
        rows = np.flatnonzero(np.isin(owner, social(ground.traffic[s])))
        rows = rows[arena.allows(np.full(len(rows), s), owner[rows], planned[c][rows])]
        odds = np.concatenate(choice.natural)[rows]
        found.append(Candidates(np.full(len(rows), s), owner[rows], goal[rows], odds, planned[c][rows].padded(steps)))
    return Candidates.joined(found)
