"""Corner cases driven again from any step on: the target as it was driven until then, and by an evasion from there.

Everybody else does what it did, and beyond the scenario's end keeps its velocity: an evasion that only puts a collision off until
then avoids nothing. Where neighbours react, all but the attacker do, from the beginning of the evasion on.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.corner_cases.case import Case
from drivegen.world.bicycle import placed
from drivegen.world.ego import Ego
from drivegen.world.ends import Surface, exits
from drivegen.world.neighbours import Neighbours, Replayed
from drivegen.world.observation import Action
from drivegen.world.outcome import ARTEFACTS
from drivegen.world.paths import target_paths
from drivegen.world.reactive import Reaction, Reactive
from drivegen.world.scenes import Scenes
from drivegen.world.touch import kinds, touched
from drivegen.world.world import World

WATCH = 30
"""An evasion has to keep clear for so many steps beyond the collision that it avoids."""

SWERVE = 3.0
"""[m/s2] The lateral acceleration of an evasion, the limit of UN R157 for lane keeping at speed."""


ROWS = 64
"""Rows are padded to a multiple of this by repeating: the last ones of a batch are computed as all others are, to the bit."""


@dataclass(frozen=True)
class Evasion:
    """What a target does from some step on.

    Attributes:
        braking: [m/s2], reached after `ramp` [s] at an even rate. offset: [m] to the left of where the target is.
    """

    braking: float
    ramp: float = 0.0
    offset: float = 0.0


@dataclass(frozen=True)
class Reenactment:
    """C cases with the tables that they are driven again in.

    Attributes:
        scenes: Scenes of the C cases. surface: where their roads are.
        way_out: (C,) [m] how far along their paths they leave the map, inf if never.
        attacker: (C,) int64 the vehicle that does not react. partner: (C,) int64 the other that was hit, from 0 on.
        contact, end: (C,) int64 steps of the collision, and until which an evasion is watched.
        driven: Trajectories (C, T) of the targets. other: (C, T) of the others that were hit; other_size: (C, 2) [m] theirs.
    """

    scenes: Scenes
    surface: Surface
    way_out: Tensor
    attacker: Tensor
    partner: NDArray[np.int64]
    contact: NDArray[np.int64]
    end: NDArray[np.int64]
    driven: Trajectories
    other: Trajectories
    other_size: NDArray[np.float32]

    @classmethod
    def of(cls, cases: Sequence[Case]) -> Self:
        """Pack cases; about 150 kB each."""
        scenarios, traffic = [case.scenario for case in cases], [case.traffic for case in cases]
        steps, contact = max(motion.steps for motion in traffic), np.array([case.step for case in cases])
        paths, lasts = target_paths(scenarios, traffic), contact + WATCH + 1
        going_on = [_with_people_going_on(scenario, last) for scenario, last in zip(scenarios, lasts.tolist(), strict=True)]
        traffic = [_going_on(motion, last) for motion, last in zip(traffic, lasts.tolist(), strict=True)]
        scenes = Scenes.of(going_on, traffic, paths)
        return cls(
            scenes,
            Surface.of(scenarios),
            exits(scenes, scenarios),
            torch.tensor([case.deaf for case in cases]),
            np.array([case.partner - 1 for case in cases]),
            contact,
            contact + WATCH,
            _stacked([case.driven for case in cases], steps),
            _stacked([case.other[0].until(case.traffic.steps) for case in cases], steps),
            np.stack([case.other[1][:2] for case in cases]),
        )

    def ego(self, case: Tensor, step: Tensor) -> Ego:
        """The targets of cases `case` (R,) as they were driven at `step` (R,)."""
        position, heading = torch.from_numpy(self.driven.position), torch.from_numpy(self.driven.heading)
        moved = (position[:, 1:] - position[:, :-1]).norm(dim=-1)
        along = torch.nn.functional.pad(moved.cumsum(1), (1, 0))[case, step]
        start = Ego.at_start(torch.from_numpy(self.driven.speed)[case, step], self.scenes.paths[case])
        return placed(replace(start, along=along), position[case, step], heading[case, step], self.scenes.paths[case])

    def avoids(
        self,
        case: NDArray[np.integer],
        step: NDArray[np.integer],
        evasion: Sequence[Evasion],
        reaction: Reaction | None = None,
    ) -> NDArray[np.bool_]:
        """(R,) whether `case` (R,) is avoided where its target evades by `evasion` (R,) from `step` (R,) on.

        A case is avoided where the target stays on the road and hits nobody until the end or its way out of the map, and nobody
        hits it. One exception:
        where neighbours are replayed, others than the partner may hit it from behind, or while it stands; who has done so is
        passed through from then on.
        """
        rows = np.resize(np.arange(len(case)), -(-len(case) // ROWS) * ROWS)
        whole, begin = case[rows], step[rows]
        scene, first = torch.from_numpy(whole.astype(np.int64)), torch.from_numpy(begin.astype(np.int64))
        plan = _Plan.of([evasion[row] for row in rows.tolist()])
        with torch.inference_mode():
            world = World(self.scenes, len(rows), self._neighbours(len(rows), reaction))
            world.resume(scene, first, self.ego(scene, first))
            good = self._drive(world, plan, whole, self.end[whole] - begin, strict=reaction is not None)
        return good[: len(case)]

    def _neighbours(self, rows: int, reaction: Reaction | None) -> Neighbours:
        return Reactive(self.scenes, rows, reaction, self.attacker) if reaction else Replayed(self.scenes)

    def _drive(
        self, world: World, plan: "_Plan", case: NDArray[np.integer], steps: NDArray[np.integer], strict: bool
    ) -> NDArray[np.bool_]:
        watched, good = np.ones(len(case), np.bool_), np.ones(len(case), np.bool_)
        offset, was_off = world.ego.offset, self._off_road(world)
        moment = world.ego, world.neighbours.boxes(world)
        passed = np.zeros((len(case), self.scenes.present.shape[1]), np.bool_)
        for k in range(int(steps.max(initial=0))):
            world.advance(plan.action(k, offset))
            now = (world.ego, world.neighbours.boxes(world))
            watched &= (k < steps) & self._on_the_map(world)
            there = now[1].without(passed) if passed.any() else now[1]
            partner = np.where(watched, touched(world, there).numpy(), -1)
            mine = (partner >= 0) & (strict | (partner == self.partner[case]))
            kind = kinds(world, torch.from_numpy(np.where(mine, -1, partner)), moment, now).numpy()
            tolerated = np.isin(kind, ARTEFACTS)
            passed[tolerated, partner[tolerated]] = True
            good &= ~mine & ~((kind > 0) & ~tolerated)
            good &= ~(watched & plan.swerves & self._off_road(world) & ~was_off)
            watched &= good
            moment = now
        return good

    def _on_the_map(self, world: World) -> NDArray[np.bool_]:
        return np.asarray((world.ego.along < self.way_out[world.scene]).numpy())

    def _off_road(self, world: World) -> NDArray[np.bool_]:
        return np.asarray(self.surface.off_road(world.scene, world.ego.position, world.ego.heading, world.size).numpy())


@dataclass(frozen=True)
class _Plan:
    """R evasions as arrays (R,)."""

    braking: Tensor
    ramp: Tensor
    offset: Tensor

    @classmethod
    def of(cls, evasion: Sequence[Evasion]) -> Self:
        return cls(
            *(torch.tensor([getattr(e, name) for e in evasion], dtype=torch.float32) for name in ("braking", "ramp", "offset"))
        )

    @property
    def swerves(self) -> NDArray[np.bool_]:
        return np.asarray((self.offset != 0).numpy())

    def action(self, k: int, start: Tensor) -> Action:
        """The actions of the step after `k`, for targets that were `start` (R,) to the left of their paths."""
        now = (k + 1) * DT
        share = (now / self.ramp.clamp_min(DT)).clamp_max(1.0)
        size, half = self.offset.abs(), (self.offset.abs() / SWERVE).sqrt()  # half of the time that the swerve takes
        left = (2 * half - now).clamp_min(0.0)
        moved = torch.where(half > now, 0.5 * SWERVE * now**2, size - 0.5 * SWERVE * left**2)
        return Action(-self.braking * share, start + self.offset.sign() * moved)


def _going_on(motion: Trajectories, steps: int) -> Trajectories:
    """`motion` (..., T) for `steps` steps, if it has fewer: who is there at its end keeps its velocity."""
    first = motion.steps
    if steps <= first:
        return motion
    whole, ended = motion.padded(steps), motion.between(first - 1, first)
    seconds = (DT * np.arange(1, steps - first + 1, dtype=np.float32))[:, None]
    whole.position[..., first:, :] = ended.position + seconds * ended.velocity
    whole.velocity[..., first:, :], whole.heading[..., first:] = ended.velocity, ended.heading
    whole.valid[..., first:] = ended.valid
    return whole


def _with_people_going_on(scenario: Scenario, steps: int) -> Scenario:
    return replace(scenario, context=replace(scenario.context, motion=_going_on(scenario.context.motion, steps)))


def _stacked(motions: Sequence[Trajectories], steps: int) -> Trajectories:
    """Motions (T_i,) as one (C, T), standing where they end."""
    return Trajectories.joined([motion.standing_after_end().padded(steps)[np.newaxis] for motion in motions])
