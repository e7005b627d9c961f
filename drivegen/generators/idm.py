"""Everybody an IDM driver: each vehicle takes one of its ways and follows the Intelligent Driver Model on it.

No neural network: the driver is `drivers.idm` with the parameters of its settings, in closed loop with all the others of its
sample, the context actors and red lights. Samples differ by the ways (drawn evenly among those that the lane graph offers) and by
each vehicle's wish: desired speed over the speed limit, whose mean and spread are measured on the train logs. What is in
those: of each vehicle that drove at `free_share` of the limit or more, the highest share that it reached.

There is no right of way at junctions without signals: IDM sees who crosses only once he is in the way. Collisions there
are what this model makes of traffic.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen import seeds
from drivegen.drivers.idm import Plugin as Driver
from drivegen.drivers.idm import Settings as DriverSettings
from drivegen.errors import UnusableInput
from drivegen.generators._idm.traffic import Crowd, drive, motion
from drivegen.generators._idm.ways import Ways
from drivegen.generators._learned import Learned
from drivegen.lanes.graph import LaneGraph
from drivegen.samples import Samples
from drivegen.scenario import Scenario
from drivegen.training import loop
from drivegen.training.curve import LossRow

WISHES = (0.5, 1.5)
"""A wish is never drawn below or above these shares of the limit."""

TO_SPREAD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation: a vehicle that comes off a faster road
shall not count for ten."""

ON_LANE = 2.0
"""[m] A lane's limit holds for who is this near to its line."""


@dataclass(frozen=True)
class IdmSettings:
    """Values stand in params.yaml, `train_generator.generators.idm`.

    Attributes:
        driver: see `drivers.idm`. ways: of a vehicle at most. lane_changes: on a way at most.
        free_share: of the limit; a vehicle that never drove as fast had no free road, and says nothing about its wish.
    """

    driver: DriverSettings
    ways: int
    lane_changes: int
    free_share: float


@dataclass(frozen=True)
class Wishes:
    """Highest share (V,) of the speed limit that each of V logged vehicles reached."""

    share: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.share)

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """See `_learned.Examples`."""
        return cls(np.concatenate([np.zeros(0), *(p.share for p in parts)]))


class WishDistribution(nn.Module):
    """The two numbers that are measured: mean and standard deviation of the wishes."""

    mean: Tensor
    spread: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("mean", torch.ones(()))
        self.register_buffer("spread", torch.ones(()))


class Plugin(Learned):
    """See the module."""

    name = "idm"
    Settings = IdmSettings
    Examples = Wishes

    net: WishDistribution

    @classmethod
    def network(cls, settings: IdmSettings) -> nn.Module:
        """See `Learned`."""
        del settings
        return WishDistribution()

    @classmethod
    def examples(cls, settings: IdmSettings, scenarios: Sequence[Scenario]) -> Wishes:
        """Highest shares of their limits that the logged vehicles reached."""
        return Wishes(np.concatenate([np.zeros(0), *(_shares(s, settings.free_share) for s in scenarios if s.log is not None)]))

    @classmethod
    def objective(cls, settings: IdmSettings, net: nn.Module, train: Wishes, validation: Wishes, seed: int) -> loop.Objective:
        """Nothing is minimised: `fit` measures."""
        raise NotImplementedError("idm is measured, not trained")

    @classmethod
    def fit(
        cls,
        settings: IdmSettings,
        train: Wishes,
        validation: Wishes,
        seed: int,
        checkpoints: Path | None,
        report: Callable[[str], None],
    ) -> tuple[Self, list[LossRow]]:
        """Mean and spread of the wishes; the curve is one row of their negative log-likelihoods."""
        del seed, checkpoints
        if len(train) == 0:
            raise UnusableInput("no logged vehicle drove freely on a road with a speed limit", reason="no-examples")
        made = cls.__new__(cls)
        made.settings, made.net = settings, WishDistribution()
        middle = float(np.median(train.share))
        made.net.mean.fill_(middle)
        made.net.spread.fill_(max(TO_SPREAD * float(np.median(np.abs(train.share - middle))), 1e-3))
        made._ready()
        row = LossRow(1, made._surprise(train), made._surprise(validation))
        report(f"{len(train)} vehicles drove freely: {float(made.net.mean):.3f} +- {float(made.net.spread):.3f} of the limit")
        return made, [row]

    @property
    def parameters(self) -> int:
        """Mean and spread."""
        return 2

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K futures of each scenario."""
        return [self._of(scenario, samples, seeds.rng(seed, self.name, scenario.scenario_id)) for scenario in scenarios]

    def _of(self, scenario: Scenario, samples: int, rng: np.random.Generator) -> Samples:
        ways = Ways.of(scenario, self.settings.ways, self.settings.lane_changes)
        draws = rng.random((samples, len(scenario.vehicles)))
        way = (ways.start[:-1] + (draws * np.diff(ways.start)).astype(np.intp)).reshape(-1)
        wish = rng.normal(float(self.net.mean), float(self.net.spread), way.shape).clip(*WISHES).astype(np.float32)
        known = np.nan_to_num(ways.limit[way], nan=self.settings.driver.desired_speed)
        crowd = Crowd.of(scenario, ways.point[way], known * wish[:, None], ways.lane[way], ways.parked)
        driven = drive(crowd, Driver(self.settings.driver), scenario.steps)
        return Samples.without_goals(scenario.scenario_id, self.name, motion(crowd, scenario, *driven))

    def _surprise(self, wishes: Wishes) -> float:
        """Mean negative log-likelihood of the normal distribution; NaN for no wishes."""
        if len(wishes) == 0:
            return float("nan")
        off = (wishes.share - float(self.net.mean)) / float(self.net.spread)
        return float(0.5 * np.mean(off**2) + np.log(float(self.net.spread) * np.sqrt(2 * np.pi)))


def _shares(scenario: Scenario, free_share: float) -> NDArray[np.float64]:
    """(V,) highest share of the limit that each vehicle reached, of those that reached `free_share`."""
    log = scenario.log
    assert log is not None
    lane, _ = LaneGraph.of(scenario.map).nearest(log.position[log.valid], log.heading[log.valid], ON_LANE, np.pi / 4)
    limit = np.where(lane >= 0, scenario.map.speed_limit[lane], np.nan)
    share = np.zeros(log.valid.shape)
    share[log.valid] = np.nan_to_num(log.speed[log.valid] / limit)
    highest = share.max(axis=1)
    return np.asarray(highest[highest >= free_share], np.float64)
