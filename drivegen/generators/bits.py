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

from drivegen.core.geometry import rotate, unit
from drivegen.core.methods import Method
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.core.settings import Count, NotNegative, expect_multiple
from drivegen.generators._bits.learning import HELD_OUT, BitsObjective, DrivingExamples, Logs, told
from drivegen.generators._bits.net import HOLD, BitsNet, Plan
from drivegen.generators._bits.raster import Painted
from drivegen.generators._bits.rules import EVERY, broken
from drivegen.generators.shared.closed_loop import Crowd, Tracks
from drivegen.generators.shared.driving import Agents, ClosedLoop, Draw, expect_commits, in_chunks
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


@dataclass(frozen=True)
class BitsSettings:
    """Values stand in params.yaml, `train_generator.generators.bits`.

    Attributes:
        width: of the networks, a multiple of 16.
        horizon: steps to a goal. commit: steps of a plan that are driven before the next, at most all; multiples of 5.
        goals: drawn for each vehicle and plan.
        collision, off_road, likelihood: weights of a plan's share of looks with somebody hit, of those off the road, and of the
            log-odds of its goal.
        clearance: [m] by which boxes must be apart.
        training: see `training.loop.Settings`.
    """

    width: Count
    horizon: Count
    commit: Count
    goals: Count
    collision: NotNegative
    off_road: NotNegative
    likelihood: NotNegative
    clearance: NotNegative
    training: loop.Settings

    def __post_init__(self) -> None:
        place = "train_generator.generators.bits"
        expect_multiple(f"{place}.width", self.width, 16)
        expect_commits(place, self.horizon, self.commit, HOLD)


class Plugin(ClosedLoop):
    """See `generators.shared.driving.ClosedLoop`."""

    name = "bits"
    tempered = True
    chunk = 128
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

    def roads(self, scenarios: Sequence[Scenario]) -> Painted:
        """See `ClosedLoop`."""
        return Painted.of(scenarios)

    def planned(self, roads: Painted, agents: Agents, crowd: Crowd, draw: Draw) -> Trajectories:
        """See `ClosedLoop`: goals are drawn, and of the plans towards them the one is taken that breaks the fewest rules."""
        s = self.settings

        def ask(box: NDArray[np.integer]) -> tuple[Tensor, ...]:
            pictures, numbers = told(roads, crowd, box, s.horizon * DT)
            seen = self.net.see(pictures, numbers)
            return numbers, *seen, *self.net.predict(seen.code, numbers)

        numbers, code, logit, goals, *expected = agents.asked(crowd, self.chunk, ask)
        cell = _drawn(logit / self.temperature, torch.from_numpy(draw(s.goals)))
        every = np.arange(len(cell))
        goal = goals[every[:, None], cell]
        plan = Plan(*in_chunks(every, self.chunk, lambda some: self.net.plan(code[some], numbers[some], goal[some])))
        state, looks = crowd.state[agents.box], slice(EVERY - 1, None, EVERY)
        pose, predicted = _poses(state, plan), _extrapolated(crowd, s.horizon)
        predicted[agents.box] = _poses(state, Plan(*(part[:, None] for part in expected)))[:, 0, looks]
        hit, off = broken(np.ascontiguousarray(pose[:, :, looks]), predicted, crowd, roads, agents.box, s.clearance)
        likelihood = torch.log_softmax(logit, dim=1)[every[:, None], cell].numpy()
        best = (s.likelihood * likelihood - s.collision * hit - s.off_road * off).argmax(axis=1)  # the first of equals
        taken = every, best, slice(s.commit)
        place, angle, speed = pose[..., :2][taken], pose[..., 2][taken], plan.speed.numpy()[taken]
        return Trajectories(place, angle, unit(angle) * speed[..., None], np.ones(angle.shape, np.bool_))


def _drawn(logit: Tensor, chance: Tensor) -> Tensor:
    """Cells (R, M) of heat maps (R, CELLS), drawn with `chance` (R, M) in [0, 1)."""
    odds = torch.log_softmax(logit, dim=1).double().exp().cumsum(dim=1)
    return torch.searchsorted(odds, chance * odds[:, -1:], right=True).clamp(max=odds.shape[1] - 1)


def _poses(state: NDArray[np.float32], plan: Plan) -> NDArray[np.float32]:
    """(R, M, T, 3) x, y, heading on the map of plans (R, M, T) from states (R, 5)."""
    heading = state[:, 2, None, None]
    place = state[:, None, None, :2] + rotate(plan.place.numpy(), heading)
    return np.concatenate([place, (heading + plan.turn.numpy())[..., None]], axis=-1)


def _extrapolated(crowd: Crowd, horizon: int) -> NDArray[np.float32]:
    """(X, L, 3) x, y, heading of all boxes every EVERY steps if they keep their velocity: what is expected of context actors."""
    time = np.arange(EVERY, horizon + 1, EVERY, dtype=np.float32)[:, None] * np.float32(DT)
    place = crowd.state[:, None, :2] + crowd.state[:, None, 3:5] * time
    return np.concatenate([place, np.broadcast_to(crowd.state[:, None, 2:3], (*place.shape[:2], 1))], axis=-1)
