"""Planner `route_fm`: flow matching of low-rank residuals in the frame of the retrieved route (default).

The paper retrieves a route for every goal and then generates all of the motion by diffusion. Here the route does most of
the work: a base meets the initial state and the goal exactly (`shared.profile`, `shared.motion`), and what is left of a
logged track, when and how it brakes, accelerates and moves across its lane, is a short vector: principal components of the
residuals' spline coefficients. A small network learns to draw it (`shared.flow`), so thousands of trajectories cost a
CPU-second, and a goal is met by construction, not by hope. Without a route the path is a Bezier curve from pose to pose
(`shared.paths`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import expect_multiple
from drivegen.planners._route_fm.features import FEATURES, features
from drivegen.planners.base import Examples, PlanRequests
from drivegen.planners.shared.fitting import encode
from drivegen.planners.shared.flow import FlowNet, dense_encoder
from drivegen.planners.shared.flow_planner import Coefficients, Components, FlowPlanner, FlowSettings
from drivegen.planners.shared.latent import expanded
from drivegen.planners.shared.motion import GRID, Residuals, decode
from drivegen.planners.shared.paths import Frames
from drivegen.planners.shared.profile import spline


@dataclass(frozen=True)
class RouteFmSettings(FlowSettings):
    """See `FlowSettings`.

    Attributes:
        along, across: principal components kept along and across the route; their sum is even.
    """

    along: Components
    across: Components

    def __post_init__(self) -> None:
        expect_multiple("train_planner.planners.route_fm: along and across together", self.along + self.across, 2)


class Plugin(FlowPlanner[RouteFmSettings]):
    """See `planners.base.Planner`."""

    name = "route_fm"
    keeps = "to their path"
    Settings = RouteFmSettings

    def _coefficient_counts(self) -> dict[str, int]:
        return {"along": self.settings.along, "across": self.settings.across}

    def _new_net(self) -> FlowNet:
        s = self.settings
        return FlowNet(dense_encoder(FEATURES, s.width, s.dropout), self.size, s.width, s.blocks, s.dropout)

    def _encoded(self, examples: Examples) -> tuple[NDArray[np.float32], Coefficients]:
        frames = Frames.of(examples.requests)
        codes = encode(frames, examples.requests, examples.motion)
        coefficients = {"along": codes.along[codes.usable], "across": codes.across[codes.usable]}
        return features(frames, examples.requests)[codes.usable], coefficients

    def _planned(self, _: Sequence[Scenario], requests: PlanRequests, steps: int, /) -> Trajectories:
        frames, latents = Frames.of(requests), np.zeros((len(requests), self.size), np.float32)
        moves = (frames.distance > 0) & ~requests.parked  # nothing is drawn for who stays
        latents[moves] = self._latents(features(frames, requests)[moves], requests[moves])
        return decode(frames, requests, self._residuals(latents), steps)

    def inputs(self, requests: PlanRequests) -> NDArray[np.float32]:
        """(B, F) what the network is told of requests."""
        return features(Frames.of(requests), requests)

    def motion(self, requests: PlanRequests, latents: NDArray[np.float32], steps: int) -> Trajectories:
        """Motion (B, steps) of latents (B, Z)."""
        return decode(Frames.of(requests), requests, self._residuals(latents), steps)

    def _residuals(self, latents: NDArray[np.float32]) -> Residuals:
        """Residuals of latents (B, Z) on the grid."""
        value, slope = spline(np.linspace(0.0, 1.0, GRID))
        along, across = np.split(latents, [self.settings.along], axis=1)
        return Residuals(
            pace=expanded(along, self.basis, "along", slope),
            offset=expanded(across, self.basis, "across", value),
            slope=expanded(across, self.basis, "across", slope),
        )
