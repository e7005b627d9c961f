"""Candidates that are motions: tracks of social vehicles with other accelerations and curvatures, judged in each scene.

A vehicle that is there throughout has so many of them for each of its goals; others have none.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Arena, social
from drivegen.adversaries.shared.bicycle import perturbed
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.core import seeds
from drivegen.core.scenario import Trajectories
from drivegen.core.settings import Count, Positive


@dataclass(frozen=True)
class Perturbation:
    """`knots`: values of each, held in turn over the horizon. `acceleration` [m/s2], `curvature` [1/m]: largest changes."""

    knots: Count
    acceleration: Positive
    curvature: Positive

    def draw(self, track: Trajectories, count: int, random: np.random.Generator) -> Trajectories:
        """(count, T) the track (T,), changed at random."""
        bounds = (self.acceleration, self.curvature)
        return perturbed(track, *(random.uniform(-bound, bound, (count, self.knots)) for bound in bounds))


def exchanged_motions(arena: Arena, perturbation: Perturbation, draws: int, scenes: NDArray[np.int64]) -> Candidates:
    """All that the arena allows in `scenes`, of `draws` for each goal that a vehicle has."""
    asked = ("motions", perturbation, draws, *scenes.tolist())
    if asked not in arena.made:
        arena.made[asked] = Candidates.joined([_drawn(arena, perturbation, draws, s) for s in scenes.tolist()])
    made: Candidates = arena.made[asked]
    return made


def _drawn(arena: Arena, perturbation: Perturbation, draws: int, scene: int) -> Candidates:
    traffic, choice = arena.ground.traffic[scene], arena.ground.choices[int(arena.ground.of[scene])]
    throughout = [n for n in social(traffic).tolist() if traffic.valid[n].all()]
    counts = [draws * len(choice.candidates[n]) for n in throughout]
    streams = (seeds.rng(arena.seed, "exchanged motions", choice.scenario.scenario_id, n) for n in throughout)
    parts = [perturbation.draw(traffic[n], count, random) for n, count, random in zip(throughout, counts, streams, strict=True)]
    motion = Trajectories.joined([Trajectories.empty(0, traffic.steps), *parts]).padded(arena.trials.steps)
    where, vehicle = np.full(sum(counts), scene), np.repeat(np.array(throughout, np.int64), counts)
    motion = arena.on_the_map(where, vehicle, motion)
    kept = np.flatnonzero(arena.allows(where, vehicle, motion))
    no_goal, no_odds = np.full(len(kept), -1), np.full(len(kept), np.nan, np.float32)
    return Candidates(where[kept], vehicle[kept], no_goal, no_odds, motion[kept])
