"""Neighbours that react: each along its own motion as it was logged or generated, at the speed planned for each place.

Each neighbour follows its plan by a clock of its own. Undisturbed, the clock shows the world's time and the neighbour is where it
was planned to be; while it brakes, its clock runs slower. It brakes like an IDM follower for boxes on its way that its plan does
not know of: the target, and neighbours that are late; a neighbour that is late itself brakes for everybody. It begins to
brake `delay` after braking was first needed, at most by `braking`. Where a plan stands still, as at a red light, its clock
catches up with the world's: a late neighbour waits no longer than the others. People and bicycles of the context do not react.

Sources: IDM (Treiber, Hennecke, Helbing 2000); a driver's delay and braking as in UN Regulation 157.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from drivegen.core.scenario import DT
from drivegen.core.settings import NotNegative, Positive
from drivegen.world.neighbours import Boxes
from drivegen.world.observation import STANDING
from drivegen.world.plan import ARC, HEADING, Plan, between
from drivegen.world.scenes import Scenes
from drivegen.world.way import Traffic, demands, looks_at

if TYPE_CHECKING:
    from drivegen.world.world import World

LATE = 0.01
"""Who is behind its plan by more than this [steps] is late."""

_SAME = 1e-3
"""[s] Sums of steps of DT miss a delay that is so many of them by less than this."""


@dataclass(frozen=True)
class Reaction:
    """How neighbours react.

    Attributes:
        delay: [s] from when it has to brake until it does. braking: the hardest [m/s2].
        headway: T [s], min_gap: s0 [m], acceleration: a, also back to the planned speed, comfort: b [m/s2] of the IDM.
    """

    delay: NotNegative
    braking: Positive
    headway: NotNegative
    min_gap: NotNegative
    acceleration: Positive
    comfort: Positive


class Reactive:
    """See the module.

    Attributes:
        clock: (R, M) the step of its plan that each is at. speed: (R, M) [m/s]. watched: (R, M) [s] since it first had to brake.
        hardest: (R,) [m/s2] the hardest that anybody has braked for the target. taken: (R,) [m/s] speed that braking for the
            target has taken from all neighbours together.
    """

    def __init__(
        self, scenes: Scenes, rows: int, reaction: Reaction, attacker: Tensor | None = None, to_target_alone: bool = False
    ) -> None:
        """`attacker` (S,) int64: the vehicle of each scene that does not react, 0 where all do. They react to everybody, or
        `to_target_alone`: through one another they drive as planned.
        """
        self._scenes, self._law, self._plan, self._to_target_alone = scenes, reaction, Plan.of(scenes), to_target_alone
        device = scenes.steps.device
        self._reacts = torch.from_numpy(scenes.replay.vehicle).to(device)
        if attacker is not None:
            number = torch.arange(1, self._reacts.shape[1] + 1, device=device)
            self._reacts = self._reacts & (number != attacker.to(device)[:, None])
        self.clock = torch.zeros((rows, self._reacts.shape[1]), device=device)
        self.speed, self.watched = torch.zeros_like(self.clock), torch.zeros_like(self.clock)
        self.hardest, self.taken = torch.zeros_like(self.clock[:, 0]), torch.zeros_like(self.clock[:, 0])

    def reset(self, world: "World", rows: Tensor | None) -> None:
        """See `Neighbours`."""
        chosen = rows if rows is not None else slice(None)
        for state in (self.watched, self.hardest, self.taken):
            state[chosen] = 0.0
        self.clock[chosen] = world.step[chosen, None].to(self.clock)
        self.speed[chosen] = self._plan.speed[world.at[chosen]]

    def seen(self, world: "World") -> tuple[Tensor, Tensor]:
        """See `Neighbours`; they are seen at the speed that they have."""
        before, after, share, present = self._steps(world)
        frame = between(self._scenes.frame, before, after, share)
        planned = torch.hypot(frame[:, 4], frame[:, 5])
        slower = (self.speed / planned.clamp_min(STANDING)).clamp_max(1.0)
        frame[:, 4:] *= torch.where(self._late(world), slower, 1.0)[:, None]
        return frame, present

    def rows(self, world: "World") -> Tensor:
        """See `Neighbours`."""
        return self._steps(world)[0]

    def boxes(self, world: "World") -> Boxes:
        """See `Neighbours`."""
        pose, present = self._pose(world)
        rows = torch.arange(len(pose), device=pose.device)
        return Boxes(rows, pose[:, :2].transpose(1, 2).contiguous(), pose[:, HEADING].contiguous(), present)

    def advance(self, world: "World") -> None:
        """See `Neighbours`."""
        before, after, share, _ = self._steps(world)
        planned = between(self._plan.speed[:, None], before, after, share)[:, 0]
        late = self._late(world)
        following = self._plan.speed.gather(0, world.following[:, None].expand_as(before))
        wished = torch.where(late, (planned - self.speed) / DT, (following - self.speed) / DT)
        wished = torch.where(late, wished.clamp_max(self._law.acceleration), wished)
        demand, for_target = self._demand(world, late)
        attentive = self.watched >= self._law.delay - _SAME
        noticed = (demand < 0) | (attentive & (demand < wished))
        self.watched = torch.where(noticed, self.watched + DT, 0.0)
        brakes = attentive & noticed & (demand < wished)
        acceleration = torch.where(brakes, demand.clamp_min(-self._law.braking), wished)
        speed = (self.speed + acceleration * DT).clamp_min(0.0)
        self._impose(brakes & (for_target <= demand), speed, wished)
        self._move(world, speed, planned, before, late | brakes)

    def _demand(self, world: "World", late: Tensor) -> tuple[Tensor, Tensor]:
        """(R, M) [m/s2] the least acceleration that anybody in the way asks for, and that for the target; inf where nobody is."""
        pose, present = self._pose(world)
        ego, true = world.ego, torch.ones_like(present[:, :1])
        own = torch.stack([*ego.position.unbind(-1), ego.heading, ego.heading.cos(), ego.heading.sin()], 1)
        traffic = Traffic(
            torch.cat([pose[:, :ARC], own[..., None]], 2),
            torch.cat([self.speed, ego.speed[:, None]], 1),
            torch.cat([self._scenes.others_size[world.scene], world.size[:, None]], 1),
            torch.cat([present, true], 1),
        )
        minded = torch.zeros_like(late) if self._to_target_alone else late
        pairs = looks_at(traffic, self._reacts[world.scene], minded)
        base = (world.scene * self._scenes.longest)[:, None]
        first = base + self.clock.long()
        last = (base + self._scenes.steps[world.scene][:, None] - 1).expand_as(first)
        accelerations = demands(pairs, traffic, self._plan.pose, self._scenes.present, first, last, pose[:, ARC], self._law)
        row, neighbour, box = pairs
        others = self.clock.shape[1]
        least = torch.full((self.clock.numel(),), torch.inf, device=accelerations.device)
        target, at = least.clone(), row * others + neighbour
        least.scatter_reduce_(0, at, accelerations, "amin")
        mine = box == others
        target[at[mine]] = accelerations[mine]
        return least.view_as(self.clock), target.view_as(self.clock)

    def _impose(self, braked: Tensor, speed: Tensor, wished: Tensor) -> None:
        """Remember what braking for the target takes: `speed` (R, M) that is left of what was `wished` [m/s2]."""
        loss = torch.where(braked, (self.speed + wished * DT).clamp_min(0.0) - speed, 0.0)
        rate = torch.where(braked, (self.speed - speed) / DT, 0.0)
        self.taken = self.taken + loss.sum(1)
        self.hardest = torch.maximum(self.hardest, rate.amax(1))

    def _move(self, world: "World", speed: Tensor, planned: Tensor, before: Tensor, disturbed: Tensor) -> None:
        """Let clocks run: with the world's where nothing disturbs, else as fast as the plan is driven or its halt allows."""
        following = (world.step + 1)[:, None].to(speed)
        driven = self.clock + (speed / planned.clamp_min(STANDING)).clamp_max(1.0)
        resume = self._plan.resume.gather(0, before)
        waited = torch.minimum(following, torch.maximum(resume, self.clock.floor() + 1))
        clock = torch.where(planned > STANDING, driven, waited)
        self.clock = torch.where(disturbed, torch.minimum(clock, following), following)
        on_plan = self._plan.speed.gather(0, world.following[:, None].expand_as(before))
        self.speed = torch.where(self.clock < following - LATE, torch.minimum(speed, planned), on_plan)

    def _late(self, world: "World") -> Tensor:
        return self.clock < world.step[:, None] - LATE

    def _pose(self, world: "World") -> tuple[Tensor, Tensor]:
        """Channels (R, 6, M) of `Plan.pose` at each one's clock, and who is present (R, M)."""
        before, after, share, present = self._steps(world)
        pose = between(self._plan.pose, before, after, share)
        return pose, present

    def _steps(self, world: "World") -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Table rows (R, M) just before and after each neighbour's clock, the clock's share between them, who is present."""
        lower = self.clock.long()
        last = (self._scenes.steps[world.scene] - 1)[:, None]
        base = (world.scene * self._scenes.longest)[:, None]
        before, after = base + torch.minimum(lower, last), base + torch.minimum(lower + 1, last)
        present = self._scenes.present
        share = torch.where(present.gather(0, after), self.clock - lower, 0.0)
        return before, after, share, present.gather(0, before)
