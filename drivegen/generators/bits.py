"""BITS, bi-level imitation for traffic simulation (Xu et al., ICRA 2023): goals from a heat map, a policy that drives to them.

What is the paper's: a vehicle-centred raster of the map and of the boxes around; a spatial goal network, a U-Net, gives a
heat map of places at the horizon with residuals within a cell, turn and speed; a goal-conditioned policy gives actions that a
unicycle drives; a predictor says what the others will do; of several goals drawn from the heat map, the plan is taken
that does best by rules (likelihood, collisions with predictions, leaving the road); all vehicles do so in closed loop, and plan
again after a part of the horizon.

What is reduced: a raster of 48 x 32 pixels (120 m x 64 m) and a small network whose encoder serves all three parts,
where the paper has a residual network for each; only the present frame is seen, since only the first one is given; the
predictor gives one future. What is added: speed limits, signals, ways to yield on and the place where constant velocity
leads are drawn; the raster of a fast vehicle is stretched lengthwise, or its goal would lie beyond it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core import seeds
from drivegen.core.geometry import rotate, unit
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.core.settings import Count, NotNegative, Positive, expect_multiple
from drivegen.generators._bits.learning import HELD_OUT, BitsObjective, DrivingExamples, Logs
from drivegen.generators._bits.net import HOLD, BitsNet, Plan, Seen, numbers_of
from drivegen.generators._bits.raster import Painted, rasters
from drivegen.generators._bits.rules import EVERY, broken
from drivegen.generators.shared.closed_loop import Crowd, Tracks, expect_commits
from drivegen.generators.shared.learned import Learned
from drivegen.training import loop

ABOUT = Method(
    title="BITS",
    line="A goal map of a raster, a policy towards each goal, and a choice among predicted ends (Xu et al., ICRA 2023).",
    kind="learned",
    goals=None,
    trains_on="the logs",
    places=False,
    additions=(),
)

CHUNK = 128
"""Vehicles that go through the network at once, always: sums differ between batch sizes."""

SCENES = 16
"""Scenarios that are driven on together; bounds memory."""


@dataclass(frozen=True)
class BitsSettings:
    """Values stand in params.yaml, `train_generator.generators.bits`.

    Attributes:
        width: of the networks, a multiple of 16.
        horizon: steps to a goal. commit: steps of a plan that are driven before the next, at most all; multiples of 5.
        goals: drawn for each vehicle and plan. temperature: they are drawn from `p ** (1 / temperature)`, normalised.
        collision, off_road, likelihood: weights of a plan's share of looks with somebody hit, of those off the road, and of the
            log-odds of its goal.
        clearance: [m] by which boxes must be apart.
        training: see `training.loop.Settings`.
    """

    width: Count
    horizon: Count
    commit: Count
    goals: Count
    temperature: Positive
    collision: NotNegative
    off_road: NotNegative
    likelihood: NotNegative
    clearance: NotNegative
    training: loop.Settings

    def __post_init__(self) -> None:
        place = "train_generator.generators.bits"
        expect_multiple(f"{place}.width", self.width, 16)
        expect_commits(place, self.horizon, self.commit, HOLD)


@dataclass(frozen=True)
class _Scene:
    """What does not change while some scenarios are driven: maps, and of each vehicle its box, group and scenario."""

    painted: Painted
    box: NDArray[np.int64]
    group: NDArray[np.int64]
    scene: NDArray[np.int64]
    kind: NDArray[np.uint8]
    first: NDArray[np.int64]
    same: NDArray[np.int64]


class Plugin(Learned):
    """See `generators.shared.learned.Learned`."""

    name = "bits"
    about = ABOUT
    Settings = BitsSettings
    Examples = Logs
    settings: BitsSettings
    net: BitsNet

    @classmethod
    def network(cls, settings: BitsSettings) -> BitsNet:
        """See `Learned`."""
        return BitsNet(settings.width, settings.horizon)

    @classmethod
    def examples(cls, settings: BitsSettings, scenarios: Sequence[Scenario]) -> Logs:
        """See `Learned`."""
        del settings
        logged = [s for s in scenarios if s.log is not None]
        return Logs(Tracks.of_logs(logged), Painted.of(logged))

    @classmethod
    def objective(cls, settings: BitsSettings, net: BitsNet, train: Logs, validation: Logs, seed: int) -> BitsObjective:
        """See `Learned`."""
        del net, seed
        return BitsObjective(DrivingExamples(train, settings.horizon), DrivingExamples(validation, settings.horizon, HELD_OUT))

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` futures of each scenario, driven in closed loop."""
        made = []
        with torch.inference_mode():
            for low in range(0, len(scenarios), SCENES):
                made += self._driven(scenarios[low : low + SCENES], samples, seed)
        return made

    def _driven(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        tracks = Tracks.of_beginnings(scenarios, samples)
        box = np.flatnonzero(tracks.planned)
        group = tracks.scene(box)
        scene = group // samples
        within = box - tracks.start[group]
        first, same = np.unique(scene * (within.max() + 1) + within, return_index=True, return_inverse=True)[1:]
        fixed = _Scene(Painted.of(scenarios), box, group, scene, tracks.kind[box], first, same.reshape(-1))
        randoms = [seeds.rng(seed, self.name, s.scenario_id) for s in scenarios]
        groups = np.arange(len(tracks.start) - 1)
        for step in range(0, tracks.valid.shape[1] - 1, self.settings.commit):
            shapes = [(samples * len(s.vehicles), self.settings.goals) for s in scenarios]
            chance = np.concatenate([r.random(shape) for r, shape in zip(randoms, shapes, strict=True)])
            crowd = tracks.at(groups, np.full(len(groups), step))
            tracks.drive(box, step, self._planned(fixed, crowd, step, chance))
        return tracks.samples(scenarios, samples, self.name)

    def _planned(self, fixed: _Scene, crowd: Crowd, step: int, chance: NDArray[np.float64]) -> Trajectories:
        """Motion (R, commit) of all vehicles from `step` on; `chance` (R, M) in [0, 1) draws the goals."""
        numbers, seen, prediction = self._seen(fixed, crowd, step)
        share = torch.log_softmax(seen.logit / self.settings.temperature, dim=1)
        odds = share.double().exp().cumsum(dim=1)
        cell = torch.searchsorted(odds, torch.from_numpy(chance) * odds[:, -1:], right=True).clamp(max=odds.shape[1] - 1)
        rows = torch.arange(len(cell))[:, None]
        plan = self._plans(seen.code, numbers, seen.goal[rows, cell])
        state = crowd.state[fixed.box]
        predicted = _extrapolated(crowd, self.settings.horizon)
        predicted[fixed.box] = _looks(state, Plan(*(part[:, None] for part in prediction)))[:, 0]
        hit, off = broken(
            _looks(state, plan), predicted, crowd, fixed.painted, fixed.group, fixed.box, fixed.scene, self.settings.clearance
        )
        likelihood = torch.log_softmax(seen.logit, dim=1)[rows, cell].numpy()
        score = self.settings.likelihood * likelihood - self.settings.collision * hit - self.settings.off_road * off
        best = score.argmax(axis=1)  # the first of equals, and draws come in no order
        taken = Plan(*(part.numpy()[np.arange(len(best)), best, : self.settings.commit] for part in plan))  # type: ignore[arg-type]
        return _on_map(state, taken)

    def _seen(self, fixed: _Scene, crowd: Crowd, step: int) -> tuple[Tensor, Seen, Plan]:
        """What all vehicles are told and see, and what each is expected to do.

        At step 0 the samples of a scenario are the same, so the first stands for all.
        """
        wanted = fixed.first if step == 0 else np.arange(len(fixed.box))
        parts = []
        for low in range(0, len(wanted), CHUNK):
            count = min(CHUNK, len(wanted) - low)
            rows = np.resize(wanted[low : low + count], CHUNK)
            box = fixed.box[rows]
            steps = np.full(CHUNK, step)
            pictures = rasters(fixed.painted, crowd, fixed.group[rows], box, fixed.scene[rows], steps, self.settings.horizon * DT)
            speed = np.hypot(crowd.state[box, 3], crowd.state[box, 4])
            numbers = numbers_of(*(torch.from_numpy(a) for a in (speed, crowd.size[box], fixed.kind[rows])))
            seen = self.net.see(torch.from_numpy(pictures), numbers)
            parts.append([part[:count] for part in (numbers, *seen, *self.net.predict(seen.code, numbers))])
        joined = [torch.cat(part) for part in zip(*parts, strict=True)]
        if step == 0:
            joined = [part[torch.from_numpy(fixed.same)] for part in joined]
        return joined[0], Seen(*joined[1:4]), Plan(*joined[4:])

    def _plans(self, code: Tensor, numbers: Tensor, goal: Tensor) -> Plan:
        """Plans (R, M, T), in chunks of CHUNK vehicles."""
        parts = []
        for low in range(0, len(code), CHUNK):
            count = min(CHUNK, len(code) - low)
            rows = torch.from_numpy(np.resize(np.arange(low, low + count), CHUNK))
            parts.append([part[:count] for part in self.net.plan(code[rows], numbers[rows], goal[rows])])
        return Plan(*(torch.cat(part) for part in zip(*parts, strict=True)))


def _looks(state: NDArray[np.float32], plan: Plan) -> NDArray[np.float32]:
    """(R, M, L, 3) x, y, heading on the map every EVERY steps of plans (R, M, T) from states (R, 5)."""
    at = slice(EVERY - 1, None, EVERY)
    heading = state[:, 2, None, None]
    place = state[:, None, None, :2] + rotate(plan.place[:, :, at].numpy(), heading)
    return np.concatenate([place, (heading + plan.turn[:, :, at].numpy())[..., None]], axis=-1)


def _extrapolated(crowd: Crowd, horizon: int) -> NDArray[np.float32]:
    """(X, L, 3) x, y, heading of all boxes every EVERY steps if they keep their velocity: what is expected of context actors."""
    time = np.arange(EVERY, horizon + 1, EVERY, dtype=np.float32)[:, None] * np.float32(DT)
    place = crowd.state[:, None, :2] + crowd.state[:, None, 3:5] * time
    return np.concatenate([place, np.broadcast_to(crowd.state[:, None, 2:3], (*place.shape[:2], 1))], axis=-1)


def _on_map(state: NDArray[np.float32], plan: Plan) -> Trajectories:
    """Motion (R, C) on the map of plans (R, C), arrays, from states (R, 5)."""
    heading = state[:, 2:3]
    angle = heading + plan.turn
    place = state[:, None, :2] + rotate(plan.place, heading)  # type: ignore[arg-type]
    return Trajectories(place, angle, unit(angle) * np.asarray(plan.speed)[..., None], np.ones(angle.shape, np.bool_))
