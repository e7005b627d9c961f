"""Everybody an IDM driver: each vehicle takes one of its ways and follows the Intelligent Driver Model on it.

No neural network: the driver is `drivers.idm` with the parameters of its settings, in closed loop with all the others of its
sample, the context actors and red lights. Samples differ by the ways (drawn evenly among those that the lane graph offers) and by
each vehicle's wish: desired speed over the speed limit, whose distribution is learnt from the train logs. What is in
those: of each vehicle that drove at `free_share` of the limit or more, the highest share that it reached. Whatever the
wish, everybody slows down for bends.

There is no right of way at junctions without signals: IDM sees who crosses only once he is in the way. Collisions there
are what this model makes of traffic.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core import seeds
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count, Index, Share
from drivegen.drivers.idm import Plugin as Driver
from drivegen.drivers.idm import Settings as DriverSettings
from drivegen.generators._idm.traffic import Crowd, drive, motion
from drivegen.generators._idm.ways import Ways
from drivegen.generators.shared.learned import Learned
from drivegen.generators.shared.objective import Objective
from drivegen.roads.graph import LaneGraph
from drivegen.training import loop

ABOUT = Method(
    title="IDM",
    line="Everybody an Intelligent Driver Model on a lane-graph way; wishes fitted to logs.",
    kind="rules",
    goals=None,
    trains_on="the logs",
    places=False,
    additions=(),
)

WISHES = (0.5, 1.5)
"""A wish is never drawn below or above these shares of the limit."""

ON_LANE = 2.0
"""[m] A lane's limit holds for who is this near to its line."""


@dataclass(frozen=True)
class IdmSettings:
    """Values stand in params.yaml, `train_generator.generators.idm`.

    Attributes:
        driver: see `drivers.idm`. ways: of a vehicle at most. lane_changes: on a way at most.
        free_share: of the limit; a vehicle that never drove as fast had no free road, and says nothing about its wish.
        training: see `training.loop.Settings`; it is two numbers.
    """

    driver: DriverSettings
    ways: Count
    lane_changes: Index
    free_share: Share
    training: loop.Settings


@dataclass(frozen=True)
class Wishes:
    """Highest share (V,) of the speed limit that each of V logged vehicles reached."""

    share: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.share)

    @classmethod
    def none(cls) -> Self:
        """No vehicle."""
        return cls(np.zeros(0))


class WishDistribution(nn.Module):
    """Laplace's distribution, which few odd vehicles (off a faster road, say) hardly move."""

    def __init__(self) -> None:
        super().__init__()
        self.middle = nn.Parameter(torch.tensor(1.0))
        self.log_scale = nn.Parameter(torch.tensor(-1.0))

    def forward(self, share: Tensor) -> Tensor:
        """Mean negative log-likelihood of shares (V,)."""
        loss: Tensor = ((share - self.middle).abs() * (-self.log_scale).exp() + self.log_scale + np.log(2.0)).mean()
        return loss


class WishObjective(Objective):
    """The likelihood of the logs' wishes."""

    chunk = 2**20

    def mean(self, model: nn.Module, examples: Wishes, rows: NDArray[np.integer], device: torch.device, *_: Tensor) -> Tensor:
        """See `Objective`."""
        loss: Tensor = model(torch.from_numpy(examples.share[rows]).float().to(device))
        return loss


class Plugin(Learned):
    """See the module."""

    name = "idm"
    about = ABOUT
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
        """See `Learned`."""
        del settings, net, seed
        return WishObjective(train, validation)

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K futures of each scenario."""
        return [self._of(scenario, samples, seeds.rng(seed, self.name, scenario.scenario_id)) for scenario in scenarios]

    def _of(self, scenario: Scenario, samples: int, rng: np.random.Generator) -> Samples:
        ways = Ways.of(scenario, self.settings.ways, self.settings.lane_changes)
        draws = rng.random((samples, len(scenario.vehicles)))
        way = (ways.start[:-1] + (draws * np.diff(ways.start)).astype(np.intp)).reshape(-1)
        wish = rng.laplace(float(self.net.middle), float(self.net.log_scale.exp()), way.shape).clip(*WISHES).astype(np.float32)
        wanted = np.nan_to_num(ways.limit[way], nan=self.settings.driver.desired_speed) * wish[:, None]
        crowd = Crowd.of(scenario, ways.point[way], np.minimum(wanted, ways.cap[way]), ways.lane[way], ways.parked)
        driven = drive(crowd, Driver(self.settings.driver), scenario.steps)
        return Samples.without_goals(scenario.scenario_id, self.name, motion(crowd, scenario, *driven))


def _shares(scenario: Scenario, free_share: float) -> NDArray[np.float64]:
    """(V,) highest share of the limit that each vehicle reached, of those that reached `free_share`."""
    log = scenario.log
    assert log is not None
    lane, _ = LaneGraph.of(scenario.map).nearest(log.position[log.valid], log.heading[log.valid], ON_LANE, np.pi / 4)
    limit = np.where(lane >= 0, scenario.map.speed_limit[lane], np.nan)
    share = np.zeros(log.valid.shape)
    share[log.valid] = np.nan_to_num(log.speed[log.valid] / limit)
    highest = share.max(axis=1)
    return np.asarray(np.minimum(highest[highest >= free_share], WISHES[1]), np.float64)
