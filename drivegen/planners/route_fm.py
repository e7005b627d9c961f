"""Planner `route_fm`: flow matching of low-rank residuals in the frame of the retrieved route (default).

The paper retrieves a route for every goal and then generates all of the motion by diffusion. Here the route does most of
the work: a base meets the initial state and the goal exactly (`_profile`, `_motion`), and what is left of a logged track,
when and how it brakes, accelerates and moves across its lane, is a short vector: principal components of the residuals'
spline coefficients. A small network learns to draw it (`_flow`), so thousands of trajectories cost a CPU-second, and a
goal is met by construction, not by hope. Without a route the path is a Bezier curve from pose to pose (`_paths`).
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen import seeds
from drivegen.errors import UnusableInput
from drivegen.planners._features import FEATURES, features
from drivegen.planners._flow import FlowNet, FlowObjective, dense_encoder
from drivegen.planners._latent import Basis, draw, expanded, importance, principal, whitened
from drivegen.planners._motion import GRID, Encoded, Residuals, decode, encode
from drivegen.planners._noise import normals
from drivegen.planners._paths import Frames
from drivegen.planners._profile import spline
from drivegen.planners._scores import drawn_tracks, probe
from drivegen.planners.base import Examples, PlanRequests
from drivegen.scenario import Scenario, Trajectories
from drivegen.training import loop
from drivegen.training.curve import LossRow
from drivegen.training.weights import read_weights, write_weights

GROUPS = ("along", "across")

WATCHED = 200
"""Validation tracks that are planned at each row of the loss curve."""


@dataclass(frozen=True)
class RouteFmSettings:
    """Values stand in params.yaml, `train_planner.route_fm`.

    Attributes:
        along, across: principal components kept along and across the route; their sum is even.
        width, blocks, dropout: of the network. draws: noises per example and training step.
        euler_steps: steps when sampling: 2 for the least error, 8 for the truest spread.
        training: see `training.loop.Settings`.
    """

    along: int
    across: int
    width: int
    blocks: int
    dropout: float
    draws: int
    euler_steps: int
    training: loop.Settings


class Plugin:
    """See `planners.base.Planner`."""

    Settings = RouteFmSettings

    def __init__(self, settings: RouteFmSettings) -> None:
        self.settings = settings
        self.basis: Basis = {}
        self.net = self._new_net()

    def fit(
        self, train: Examples, validation: Examples, seed: int, checkpoints: Path | None, report: Callable[[str], None]
    ) -> list[LossRow]:
        """See `planners.base.Planner`. Raises UnusableInput where fewer tracks move than there are components."""
        known, held_out = self._encoded(train), self._encoded(validation)
        if len(known[0]) < max(self.settings.along, self.settings.across):
            raise UnusableInput(f"only {len(known[0])} logged tracks move: too few to learn from", reason="no-examples")
        self.basis = principal(known[1], self.settings.along, "along") | principal(known[2], self.settings.across, "across")
        torch.manual_seed(seeds.derive(seed, "network"))
        settings, device = self.settings, loop.device()
        net = self._new_net().to(device)
        told, latents = (t.to(device) for t in self._tensors(*known))
        held = self._tensors(*held_out)
        objective = FlowObjective(
            told, latents, importance(GROUPS, self.basis).to(device), settings.draws,
            (held[0].to(device), held[1].to(device)), seeds.derive(seed, "validation"),
        )  # fmt: skip
        path = None if checkpoints is None else checkpoints / "route_fm.safetensors"
        report(f"{len(known[0])} of {len(train)} logged tracks move and keep to their path")
        drawn = drawn_tracks(validation, WATCHED, None, seed)

        def watched(net: FlowNet) -> float:
            self.net = net
            return probe(self.sample, validation, drawn, seed)

        averaged, curve = loop.train(net, objective, settings.training, seed, path, report, probe=watched)
        self.net = averaged.cpu().eval()
        return curve

    def sample(self, scenarios: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        """See `planners.base.Planner`. Raises UnusableInput if it was never trained."""
        if not self.basis:
            raise UnusableInput("planner route_fm has not been trained", reason="untrained")
        horizon = np.array([s.steps for s in scenarios])[requests.scenario]
        frames = Frames.of(requests)
        noise = normals(requests.seed, self.settings.along + self.settings.across)
        latents = draw(self.net, features(frames, requests), noise, self.settings.euler_steps)
        motion = decode(frames, requests, self._residuals(latents), int(horizon.max(initial=1)))
        motion.valid[:] = np.arange(motion.steps) < horizon[:, None]
        return motion

    def save(self, folder: Path) -> None:
        """See `planners.base.Planner`."""
        tensors = {f"net/{k}": v.cpu().numpy() for k, v in self.net.state_dict().items()}
        write_weights(
            folder, "planner", "route_fm", asdict(self.settings), tensors | {f"basis/{k}": v for k, v in self.basis.items()}
        )

    @classmethod
    def load(cls, folder: Path) -> Self:
        """See `planners.base.Planner`."""
        settings, tensors = read_weights(folder, "planner", "route_fm")
        settings["training"] = loop.Settings(**settings["training"])
        planner = cls(RouteFmSettings(**settings))
        planner.basis = {k.removeprefix("basis/"): v for k, v in tensors.items() if k.startswith("basis/")}
        weights = {k.removeprefix("net/"): torch.from_numpy(v) for k, v in tensors.items() if k.startswith("net/")}
        planner.net.load_state_dict(weights)
        planner.net.eval()
        return planner

    def _new_net(self) -> FlowNet:
        s = self.settings
        return FlowNet(dense_encoder(FEATURES, s.width, s.dropout), s.along + s.across, s.width, s.blocks, s.dropout)

    def _tensors(
        self, told: NDArray[np.float32], along: NDArray[np.float64], across: NDArray[np.float64]
    ) -> tuple[Tensor, Tensor]:
        """Features and whitened latents (E, along + across)."""
        return torch.from_numpy(told), whitened({"along": along, "across": across}, self.basis)

    def _encoded(self, examples: Examples) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.float64]]:
        """Features (E, F) and spline coefficients along and across (E, C) of the tracks that can be learnt from."""
        frames = Frames.of(examples.requests)
        encoded: Encoded = encode(frames, examples.requests, examples.motion)
        keep = encoded.usable
        return features(frames, examples.requests)[keep], encoded.along[keep], encoded.across[keep]

    def _residuals(self, latents: NDArray[np.float32]) -> Residuals:
        """Residuals of latents (B, Z) on the grid."""
        value, slope = spline(np.linspace(0.0, 1.0, GRID))
        along, across = np.split(latents, [self.settings.along], axis=1)
        return Residuals(
            pace=expanded(along, self.basis, "along", slope),
            offset=expanded(across, self.basis, "across", value),
            slope=expanded(across, self.basis, "across", slope),
        )
