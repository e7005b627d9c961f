"""DiffScene: motion of one attacker, denoised under guidance by safety, functionality and constraint terms (Xu and others, 2023).

No code of it is public: this stands in for it, on the project's flow planner. The attacker is who comes nearest to the target
as it drives, but for those behind it; its goals are drawn by their natural odds. The cost that guides, in metres:

* safety: the gap between attacker and target as it last drove;
* functionality: how much of its way the target gets before the two meet;
* constraints: acceleration beyond what is usual, and coming near to others.

The driver drives again between rounds, and the next one is guided by how it drove then.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import About
from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Arena, everywhere
from drivegen.adversaries.shared.nearest import attackers
from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import Floats
from drivegen.core.scenario import DT, Trajectories
from drivegen.core.settings import Count, NotNegative
from drivegen.corner_cases.trials import Variants
from drivegen.planners.shared.guidance import Guidance, Guided, guided
from drivegen.rollout.batch import goal_requests

ABOUT = About(
    title="DiffScene",
    traffic="generated",
    varies="motions",
    source="Xu and others, DiffScene, 2023",
    stand_in="a stand-in after the paper on the project's flow planner: no code of it is public",
)

FARTHEST = 50.0
"""[m] gaps beyond this are no gap in safety."""

USUAL = 3.0
"""[m/s2] accelerations beyond this cost."""

EVERY = 5
"""Steps between two looks at the others."""

ROOM = 0.5
"""[m] nearer than this to others costs."""


@dataclass(frozen=True)
class Settings:
    """How it is guided.

    Attributes:
        rounds: in which the budget is spent. tries: motions for each run until one is allowed.
        safety, functionality, constraints: weights of the terms. guidance: see its class.
    """

    rounds: Count
    tries: Count
    safety: NotNegative
    functionality: NotNegative
    constraints: NotNegative
    guidance: Guidance


class Plugin:
    """See the module."""

    settings_type = Settings

    def __init__(self, settings: Settings) -> None:
        self.settings = settings

    def attack(self, arena: Arena) -> None:
        """See `base.Adversary`."""
        of, settings = arena.ground.of, self.settings
        scenes = np.unique(of, return_index=True)[1].astype(np.int64)
        driven = everywhere(arena.drive(Variants.unchanged(scenes, arena.trials.steps)).to_the_end, scenes, len(of))
        who = attackers(arena, scenes, driven)
        scenes, who = scenes[who >= 0], who[who >= 0]
        for turn in range(settings.rounds if len(scenes) else 0):
            most = arena.share_of(settings.rounds - turn)
            scene, vehicle = (np.repeat(each, most[of[scenes]] * settings.tries) for each in (scenes, who))
            motion, odds = self._denoised(arena, scene, vehicle, driven, turn)
            motion = arena.on_the_map(scene, vehicle, motion)
            order = np.flatnonzero(arena.allows(scene, vehicle, motion))
            rows = arena.first_allowed(scene, vehicle, motion, order, most)
            outcome = arena.drive(Variants.one_each(scene[rows], vehicle[rows], motion[rows]), odds[rows])
            driven.put(scene[rows], outcome.to_the_end)

    def _denoised(
        self, arena: Arena, scene: NDArray[np.int64], vehicle: NDArray[np.int64], driven: Trajectories, turn: int
    ) -> tuple[Trajectories, NDArray[np.float32]]:
        """Guided motion (B, T) of attackers (B,) towards goals drawn by their odds (B,)."""
        ground = arena.ground
        planner = ground.planner
        if not isinstance(planner, Guided):
            raise UnusableInput("diffscene guides a planner's latents: set attack.planner to route_fm")
        scenario, wanted = ground.of[scene], []
        odds = np.empty(len(scene), np.float32)
        for c, choice in enumerate(ground.choices):
            mine = np.flatnonzero(scenario == c)
            random = seeds.rng(arena.seed, "diffscene", choice.scenario.scenario_id, turn)
            goal = np.array([_drawn(random, choice.natural[n]) for n in vehicle[mine].tolist()], np.int64)
            odds[mine] = [choice.natural[n][g] for n, g in zip(vehicle[mine].tolist(), goal.tolist(), strict=True)]
            wanted.append(np.column_stack([np.arange(len(mine)), vehicle[mine], goal, np.full(len(mine), turn)]).astype(np.int64))
        names = [choice.scenario.scenario_id for choice in ground.choices]
        requests = goal_requests(ground.choices, wanted, lambda c: seeds.derive(arena.seed, "diffscene", names[c]))

        def cost(motion: Trajectories, request: NDArray[np.intp]) -> Floats:
            return self._cost(arena, driven, scene[request], vehicle[request], motion)

        motion = guided(planner, requests, arena.trials.steps, cost, self.settings.guidance)
        return motion, odds

    def _cost(
        self,
        arena: Arena,
        driven: Trajectories,
        scene: NDArray[np.int64],
        vehicle: NDArray[np.int64],
        motion: Trajectories,
    ) -> Floats:
        """(M,) [m] of motion (M, T)."""
        settings, near = self.settings, approaches(arena.trials, driven, scene, vehicle, motion)
        completed = np.where(near.contact >= 0, near.contact / motion.steps, 1.0)
        acceleration = np.diff(motion.speed, axis=-1) / DT
        beyond = np.maximum(np.abs(acceleration) - USUAL, 0).max(axis=-1)
        cost = settings.safety * np.minimum(near.gap, FARTHEST) + settings.functionality * completed
        return np.asarray(cost + settings.constraints * (beyond + _crowding(arena, scene, vehicle, motion)), np.float64)


def _drawn(random: np.random.Generator, odds: NDArray[np.float32]) -> int:
    p = odds.astype(np.float64)
    return int(random.choice(len(p), p=p / p.sum()))


def _crowding(arena: Arena, scene: NDArray[np.int64], vehicle: NDArray[np.int64], motion: Trajectories) -> Floats:
    """(M,) [m] by how much each comes nearer than ROOM to one of the others but the target, all as discs of their widths."""
    nearest = np.full(len(scene), np.inf)
    for s in np.unique(scene).tolist():
        mine, traffic = np.flatnonzero(scene == s), arena.ground.traffic[s]
        width = arena.trials.scenarios[s].vehicles.size[:, 1]
        steps = min(traffic.steps, motion.steps)
        others = traffic.position[None, 1:, :steps:EVERY]
        apart = np.hypot(*np.moveaxis(motion.position[mine][:, None, :steps:EVERY] - others, -1, 0))
        away = apart - (width[1:][None, :, None] + width[vehicle[mine]][:, None, None]) / 2
        away[~np.broadcast_to(traffic.valid[None, 1:, :steps:EVERY], away.shape)] = np.inf
        away[np.arange(len(mine)), vehicle[mine] - 1] = np.inf
        nearest[mine] = away.min(axis=(1, 2))
    return np.maximum(ROOM - nearest, 0.0)
