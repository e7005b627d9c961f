"""AdvSim: accelerations and curvatures of one attacker, searched by the cross-entropy method (Wang and others, CVPR 2021).

The attacker is who comes nearest to the target as it drives, but for those behind it. The cost of a run is the least gap between
the two, less where a collision counts, more where one does not. What is not allowed is drawn again before it is driven, so only
runs of the driver are paid for. With one round all is drawn at once: random search.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import About
from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Arena, everywhere
from drivegen.adversaries.shared.bicycle import perturbed
from drivegen.adversaries.shared.motions import Perturbation
from drivegen.adversaries.shared.nearest import attackers
from drivegen.core import seeds
from drivegen.core.scenario import Trajectories
from drivegen.core.settings import Count, Positive
from drivegen.corner_cases.trials import Variants
from drivegen.world.outcome import DrivingOutcome

ABOUT = About(
    title="AdvSim",
    traffic="generated",
    varies="motions",
    source="Wang and others, AdvSim, CVPR 2021",
    proposer="cross-entropy, one attacker, instead of AdvSim's search",
    stand_in="its perturbations, with cross-entropy in the place of Bayesian optimisation",
)

REWARD, MALUS = 20.0, 5.0
"""[m] that a counted collision is better than contact, and that another is worse."""

LEAST = 0.1
"""Share of the first spread below which the search does not narrow."""


@dataclass(frozen=True)
class Settings(Perturbation):
    """What is varied, and how it is searched.

    Attributes:
        rounds: in which the budget is spent. elite: share of a round's runs that the next one is drawn around.
        tries: draws for each run until one is allowed.
    """

    rounds: Count
    elite: Positive
    tries: Count


class Plugin:
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        self.settings = settings

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        ground, settings = arena.ground, self.settings
        scenes = np.unique(ground.of, return_index=True)[1].astype(np.int64)
        driven = arena.drive(Variants.unchanged(scenes, arena.trials.steps)).to_the_end
        who = attackers(arena, scenes, everywhere(driven, scenes, len(ground.of)))
        scenes, who = scenes[who >= 0], who[who >= 0]
        searches = [_Search(arena, int(s), int(n), settings) for s, n in zip(scenes, who, strict=True)]
        for turn in range(settings.rounds):
            most = arena.share_of(settings.rounds - turn)
            asked = [search.ask(int(most[ground.of[search.scene]])) for search in searches]
            variants = [Variants.one_each(np.full(len(m.valid), s.scene), np.full(len(m.valid), s.attacker), m)
                        for s, m in zip(searches, asked, strict=True)]  # fmt: skip
            if not variants:
                return
            outcome = arena.drive(Variants.joined(variants))
            first = np.cumsum([0, *map(len, variants)])
            costs = _costs(arena, Variants.joined(variants), outcome)
            for search, low, high in zip(searches, first[:-1], first[1:], strict=True):
                search.tell(costs[low:high])


class _Search:
    """The search in one scene: draws within bounds around the elite of the last round."""

    def __init__(self, arena: Arena, scene: int, attacker: int, settings: Settings) -> None:
        self.arena, self.scene, self.attacker, self.settings = arena, scene, attacker, settings
        self.track = arena.ground.traffic[scene][attacker]
        self.bound = np.repeat([settings.acceleration, settings.curvature], settings.knots)
        self.mean, self.spread = np.zeros_like(self.bound), self.bound / np.sqrt(3)
        self.random = seeds.rng(arena.seed, "advsim", arena.trials.scenarios[scene].scenario_id)
        self.asked, self.told = np.zeros((0, len(self.bound))), False

    def ask(self, count: int) -> Trajectories:
        """At most `count` tracks that are allowed."""
        drawn = self._draw(count * self.settings.tries)
        scene, vehicle = np.full(len(drawn), self.scene), np.full(len(drawn), self.attacker)
        tracks = perturbed(self.track, *np.split(drawn, 2, axis=1)).padded(self.arena.trials.steps)
        tracks = self.arena.on_the_map(scene, vehicle, tracks)
        rows = np.flatnonzero(self.arena.allows(scene, vehicle, tracks))
        rows = self.arena.first_allowed(scene, vehicle, tracks, rows, count)
        self.asked = drawn[rows]
        return tracks[rows]

    def tell(self, cost: NDArray[np.floating]) -> None:
        """Costs of the tracks that were asked for."""
        if len(cost):
            self.told = True
            best = self.asked[np.argsort(cost, kind="stable")[: max(2, round(self.settings.elite * len(cost)))]]
            self.mean, self.spread = best.mean(0), np.maximum(best.std(0), LEAST * self.bound)

    def _draw(self, count: int) -> NDArray[np.float64]:
        if not self.told:
            return self.random.uniform(-self.bound, self.bound, (count, len(self.bound)))
        return np.clip(self.random.normal(self.mean, self.spread, (count, len(self.bound))), -self.bound, self.bound)


def _costs(arena: Arena, variants: Variants, outcome: DrivingOutcome) -> NDArray[np.float64]:
    """(V,) of each run, of one exchanged track."""
    cost = np.empty(len(variants))
    driven, run = outcome.to_the_end, np.arange(len(variants))
    near = approaches(arena.trials, driven, variants.scene, variants.vehicle, variants.motion, run)
    cost[:] = np.minimum(near.gap, 1e3)
    good = outcome.counted
    return np.asarray(cost - REWARD * good + MALUS * (outcome.collided & ~good))
