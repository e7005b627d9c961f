"""DriveGen-CS: goals of one attacker, planned and legal, ranked by what is known of the driver, the best of them rehearsed.

The goals that rank best are varied before anything is driven: places a little farther or nearer, other speeds there, so other
times of arrival, all planned by the planner; and each of these plans once more, shifted across on its way, so other times and
places of a change of lane. All is judged by the checker (`shared.variation`).

Knowledge is made of runs of the driver alone, which count: first each scene is driven as it is. A candidate is dangerous where
its planned motion meets the target's own, and where it gives little warning, since drivers brake for what they see in their way.
Of two alike the one comes first that accelerates, brakes and turns less: what is legal may be what hardly anybody does.
What the driver did about the first candidates then teaches which encounters (relative speed, direction, behaviour) end in a
collision: P(collision | encounter), with its denominators, ranks the rest, with `weight` (0 in the tables: it gained nothing).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import About
from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Arena, everywhere, share_out
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.sources import Goals, Source
from drivegen.adversaries.shared.strain import strain
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.core.settings import Count, NotNegative, Positive
from drivegen.corner_cases.encounters import Encounters, encounters
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.trials import Variants

ABOUT = About(
    title="DriveGen-CS",
    traffic="generated",
    varies="goals",
    source="Zhang and others, DriveGen (2025)",
    proposer="gap and warning, as DriveGen-CS has it",
)


@dataclass(frozen=True)
class Ranking:
    """How candidates are ranked.

    Attributes:
        per_scene: runs for which one more scene is attacked.
        learn_after: so many runs in each scenario what they teach is put to use.
        caution: [m/s] the gap that a second of warning is worth; 0 looks at gaps alone.
        behind: [m] the gap that coming up from behind is worth: its own duty.
        ease: [s2] the gap [m] that each m/s2 of acceleration beyond what is usual is worth (`shared.strain`).
        again: [m] the gap that each earlier candidate of the same vehicle is worth: who has failed to fail once will again.
        weight: [m] the gap that a factor of e in P(collision | encounter) is worth; 0 leaves knowledge out.
        strength: of the prior, see `Knowledge`.
    """

    per_scene: Count
    learn_after: Count
    caution: NotNegative
    behind: NotNegative
    ease: NotNegative
    again: NotNegative
    weight: NotNegative
    strength: Positive


@dataclass(frozen=True)
class Settings(Ranking):
    """`goals`: what is ranked."""

    goals: Goals


class Ranked:
    """Ranks candidates of a source and drives the best."""

    def __init__(self, settings: Ranking, source: Source) -> None:
        self.settings, self.source = settings, source

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        self.one_by_one(arena, int(arena.left.max(initial=0)))

    def one_by_one(self, arena: Arena, rounds: int) -> tuple[Candidates, NDArray[np.float32]]:
        """Single attackers in at most `rounds` of `learn_after` runs; all candidates (Q,), and what each costs (Q,) [m]."""
        settings, ground = self.settings, arena.ground
        scenes = share_out(ground.of, np.maximum(arena.left // settings.per_scene, 1))
        driven = everywhere(arena.drive(Variants.unchanged(scenes, arena.trials.steps)).to_the_end, scenes, len(ground.of))
        pool = self.source.candidates(arena, scenes)
        cost, count = self._cost(arena, pool, driven), len(pool)
        pool = self.source.varied(arena, pool, _in_turn(cost, pool, np.zeros(count, np.bool_), settings.again))
        cost = np.concatenate([cost, self._cost(arena, pool[count:], driven)])
        met = _encounters(arena, pool, driven)
        knowledge, tried = Knowledge.none(settings.strength), np.zeros(len(pool), np.bool_)
        for _ in range(rounds):
            danger = settings.weight * np.log(knowledge.probability()[met.speed_bin, met.direction, met.behaviour])
            order = _in_turn(cost - danger, pool, tried, settings.again)
            rows, outcome = pool.drive(arena, order, settings.learn_after)
            if not len(rows):
                break
            tried[rows] = True
            mine = outcome.partner == pool.vehicle[rows]
            knowledge = knowledge.with_outcomes(_some(met, rows), outcome.counted & mine, np.inf)
        return pool, cost

    def _cost(self, arena: Arena, pool: Candidates, driven: Trajectories) -> NDArray[np.float32]:
        """(Q,) [m] of each candidate; the least is the most dangerous."""
        near = approaches(arena.trials, driven, pool.scene, pool.vehicle, pool.motion)
        cost = near.cost(self.settings.caution, self.settings.behind)
        return np.asarray(cost + np.float32(self.settings.ease) * strain(pool.motion))


class Plugin(Ranked):
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings, settings.goals)


def _encounters(arena: Arena, pool: Candidates, driven: Trajectories) -> Encounters:
    """(Q,) of each candidate with the target as it drove."""
    sizes = [scenario.vehicles.size for scenario in arena.trials.scenarios]
    target = driven[pool.scene]
    own = np.array([sizes[s][TARGET] for s in pool.scene.tolist()]).reshape(-1, 3)
    other = np.array([sizes[s][n] for s, n in zip(pool.scene.tolist(), pool.vehicle.tolist(), strict=True)]).reshape(-1, 1, 3)
    met = encounters(target, own, pool.motion[:, None], other)
    return Encounters(**{name: getattr(met, name)[:, 0] for name in met.__dataclass_fields__})


def _some(met: Encounters, rows: NDArray[np.int64]) -> Encounters:
    return Encounters(**{name: getattr(met, name)[rows] for name in met.__dataclass_fields__})


def _in_turn(cost: NDArray[np.floating], pool: Candidates, tried: NDArray[np.bool_], again: float) -> NDArray[np.int64]:
    """Candidates (Q,) that were not tried, the least cost first, each vehicle's later ones dearer by `again`."""
    attacker = pool.scene * (int(pool.vehicle.max(initial=0)) + 1) + pool.vehicle
    order = np.lexsort((cost, ~tried, attacker))  # those that were tried come first
    first = np.searchsorted(attacker[order], attacker[order])
    dearer = cost.astype(np.float64).copy()
    dearer[order] += again * (np.arange(len(order)) - first)
    left = np.flatnonzero(~tried & np.isfinite(cost))
    return left[np.argsort(dearer[left], kind="stable")]
