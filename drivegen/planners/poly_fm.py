"""Planner `poly_fm`: flow matching without a route, told the lanes around the vehicle as vectors.

Where no route fits (a U-turn, a parking place, a drive off the map) there is no frame in which motion is simple. The path
then begins as a Bezier curve from pose to pose, and a residual of it in the plane is learnt together with that of the
speed along it (`_poly_fm.bends`): initial state and goal stay exact. The network is told the pieces of lane nearest to the
way (`_poly_fm.polylines`) through attention (`_poly_fm.net`); the flow is route_fm's (`shared.flow`). It learns from all
logged tracks, those with a route included, as if they had none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import Count, expect_multiple
from drivegen.planners._poly_fm.bends import bent_frames, encode, straight_on
from drivegen.planners._poly_fm.net import PolylineEncoder, own_features
from drivegen.planners._poly_fm.polylines import surroundings
from drivegen.planners.base import Examples, PlanRequests
from drivegen.planners.shared.flow import FlowNet
from drivegen.planners.shared.flow_planner import Coefficients, Components, FlowPlanner, FlowSettings
from drivegen.planners.shared.latent import expanded
from drivegen.planners.shared.motion import GRID, decode
from drivegen.planners.shared.profile import spline

GROUPS = ("along", "bend_x", "bend_y")


@dataclass(frozen=True)
class PolyFmSettings(FlowSettings):
    """See `FlowSettings`.

    Attributes:
        along, bend: principal components of the residual of speed, and of the path's in x and in y each; `along` is even.
        tokens, heads: of the attention over pieces of lane; `tokens` is a multiple of `heads`.
    """

    along: Components
    bend: Components
    tokens: Count
    heads: Count

    def __post_init__(self) -> None:
        expect_multiple("train_planner.planners.poly_fm.along", self.along, 2)
        expect_multiple("train_planner.planners.poly_fm.tokens", self.tokens, self.heads, "heads")


class Plugin(FlowPlanner[PolyFmSettings]):
    """See `planners.base.Planner`. Routes are not looked at."""

    name = "poly_fm"
    keeps = "near their curve"
    Settings = PolyFmSettings

    def _coefficient_counts(self) -> dict[str, int]:
        return dict(zip(GROUPS, (self.settings.along, self.settings.bend, self.settings.bend), strict=True))

    def _new_net(self) -> FlowNet:
        s = self.settings
        encoder = PolylineEncoder(s.tokens, s.heads, s.width, s.dropout)
        return FlowNet(encoder, self.size, s.width, s.blocks, s.dropout)

    def _encoded(self, examples: Examples) -> tuple[NDArray[np.float32], Coefficients]:
        codes = encode(examples.requests, examples.motion)
        inputs = _inputs(examples.scenarios, examples.requests[codes.usable])
        return inputs, {name: getattr(codes, name)[codes.usable] for name in GROUPS}

    def _planned(self, scenarios: Sequence[Scenario], requests: PlanRequests, steps: int, /) -> Trajectories:
        pace, bend_x, bend_y = self._curves(self._latents(_inputs(scenarios, requests), requests))
        return decode(bent_frames(requests, bend_x, bend_y), requests, straight_on(len(requests), pace), steps)

    def _curves(self, latents: NDArray[np.float32]) -> tuple[NDArray[np.float32], ...]:
        """Slope of the residual along, residuals in x and y: (B, GRID) each."""
        value, slope = spline(np.linspace(0.0, 1.0, GRID))
        parts = np.split(latents, [self.settings.along, self.settings.along + self.settings.bend], axis=1)
        tables = (slope, value, value)
        return tuple(expanded(*row) for row in zip(parts, [self.basis] * 3, GROUPS, tables, strict=True))


def _inputs(scenarios: Sequence[Scenario], requests: PlanRequests) -> NDArray[np.float32]:
    """What the network is told of requests (B, F): each vehicle itself and the lanes around it."""
    return np.concatenate([own_features(requests), surroundings(scenarios, requests)], axis=1)
