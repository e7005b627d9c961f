"""Planner `poly_fm`: flow matching without a route, told the lanes around the vehicle as vectors.

Where no route fits (a U-turn, a parking place, a drive off the map) there is no frame in which motion is simple. The path
then begins as a Bezier curve from pose to pose, and a residual of it in the plane is learnt together with that of the
speed along it (`_bends`): initial state and goal stay exact. The network is told the pieces of lane nearest to the way
(`_polylines`) through attention (`_poly_net`); the flow is route_fm's (`_flow`). It learns from all logged tracks, those
with a route included, as if they had none.
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
from drivegen.planners._bends import bent_frames, encode, straight_on
from drivegen.planners._flow import FlowNet, FlowObjective
from drivegen.planners._latent import Basis, draw, expanded, importance, principal, whitened
from drivegen.planners._motion import GRID, decode
from drivegen.planners._noise import normals
from drivegen.planners._poly_net import PolylineEncoder, own_features
from drivegen.planners._polylines import surroundings
from drivegen.planners._profile import spline
from drivegen.planners._scores import drawn_tracks, probe
from drivegen.planners.base import Examples, PlanRequests
from drivegen.scenario import Scenario, Trajectories
from drivegen.training import loop
from drivegen.training.curve import LossRow
from drivegen.training.weights import read_weights, write_weights

GROUPS = ("along", "bend_x", "bend_y")

WATCHED = 200
"""Validation tracks that are planned at each row of the loss curve."""


@dataclass(frozen=True)
class PolyFmSettings:
    """Values stand in params.yaml, `train_planner.planners.poly_fm`.

    Attributes:
        along, bend: principal components of the residual of speed, and of the path's in x and in y each; `along` is even.
        tokens, heads: of the attention over pieces of lane. width, blocks, dropout: of the flow's network.
        draws: noises per example and training step. euler_steps: steps when sampling.
        training: see `training.loop.Settings`.
    """

    along: int
    bend: int
    tokens: int
    heads: int
    width: int
    blocks: int
    dropout: float
    draws: int
    euler_steps: int
    training: loop.Settings


class Plugin:
    """See `planners.base.Planner`."""

    Settings = PolyFmSettings

    def __init__(self, settings: PolyFmSettings) -> None:
        self.settings = settings
        self.basis: Basis = {}
        self.net = self._new_net()

    def fit(
        self, train: Examples, validation: Examples, seed: int, checkpoints: Path | None, report: Callable[[str], None]
    ) -> list[LossRow]:
        """See `planners.base.Planner`. Raises UnusableInput where fewer tracks move than there are components."""
        told, known = _encoded(train)
        held_told, held = _encoded(validation)
        settings, device = self.settings, loop.device()
        if len(told) < max(settings.along, settings.bend):
            raise UnusableInput(f"only {len(told)} logged tracks move: too few to learn from", reason="no-examples")
        for name, count in zip(GROUPS, (settings.along, settings.bend, settings.bend), strict=True):
            self.basis |= principal(known[name], count, name)
        torch.manual_seed(seeds.derive(seed, "network"))
        net = self._new_net().to(device)
        objective = FlowObjective(
            told.to(device), whitened(known, self.basis).to(device), importance(GROUPS, self.basis).to(device), settings.draws,
            (held_told.to(device), whitened(held, self.basis).to(device)), seeds.derive(seed, "validation"),
        )  # fmt: skip
        path = None if checkpoints is None else checkpoints / "poly_fm.safetensors"
        report(f"{len(told)} of {len(train)} logged tracks move and keep near their curve")
        drawn = drawn_tracks(validation, WATCHED, None, seed)

        def watched(net: FlowNet) -> float:
            self.net = net
            return probe(self.sample, validation, drawn, seed)

        averaged, curve = loop.train(net, objective, settings.training, seed, path, report, probe=watched)
        self.net = averaged.cpu().eval()
        return curve

    def sample(self, scenarios: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        """See `planners.base.Planner`. Routes are not looked at. Raises UnusableInput if it was never trained."""
        if not self.basis:
            raise UnusableInput("planner poly_fm has not been trained", reason="untrained")
        horizon = np.array([s.steps for s in scenarios])[requests.scenario]
        told = np.concatenate([own_features(requests), surroundings(scenarios, requests)], axis=1)
        latents = draw(self.net, told, normals(requests.seed, self._size), self.settings.euler_steps)
        pace, bend_x, bend_y = self._curves(latents)
        motion = decode(
            bent_frames(requests, bend_x, bend_y), requests, straight_on(len(requests), pace), int(horizon.max(initial=1))
        )
        motion.valid[:] = np.arange(motion.steps) < horizon[:, None]
        return motion

    def save(self, folder: Path) -> None:
        """See `planners.base.Planner`."""
        tensors = {f"net/{k}": v.cpu().numpy() for k, v in self.net.state_dict().items()}
        write_weights(
            folder, "planner", "poly_fm", asdict(self.settings), tensors | {f"basis/{k}": v for k, v in self.basis.items()}
        )

    @classmethod
    def load(cls, folder: Path) -> Self:
        """See `planners.base.Planner`."""
        settings, tensors = read_weights(folder, "planner", "poly_fm")
        settings["training"] = loop.Settings(**settings["training"])
        planner = cls(PolyFmSettings(**settings))
        planner.basis = {k.removeprefix("basis/"): v for k, v in tensors.items() if k.startswith("basis/")}
        weights = {k.removeprefix("net/"): torch.from_numpy(v) for k, v in tensors.items() if k.startswith("net/")}
        planner.net.load_state_dict(weights)
        planner.net.eval()
        return planner

    @property
    def _size(self) -> int:
        return self.settings.along + 2 * self.settings.bend

    def _new_net(self) -> FlowNet:
        s = self.settings
        encoder = PolylineEncoder(s.tokens, s.heads, s.width, s.dropout)
        return FlowNet(encoder, self._size, s.width, s.blocks, s.dropout)

    def _curves(self, latents: NDArray[np.float32]) -> tuple[NDArray[np.float32], ...]:
        """Slope of the residual along, residuals in x and y: (B, GRID) each."""
        value, slope = spline(np.linspace(0.0, 1.0, GRID))
        parts = np.split(latents, [self.settings.along, self.settings.along + self.settings.bend], axis=1)
        tables = (slope, value, value)
        return tuple(expanded(*row) for row in zip(parts, [self.basis] * 3, GROUPS, tables, strict=True))


def _encoded(examples: Examples) -> tuple[Tensor, dict[str, NDArray[np.float64]]]:
    """Features (E, F) and the groups' spline coefficients (E, C) of the tracks that can be learnt from."""
    found = encode(examples.requests, examples.motion)
    requests = examples.requests[found.usable]
    told = np.concatenate([own_features(requests), surroundings(examples.scenarios, requests)], axis=1)
    return torch.from_numpy(told), {name: getattr(found, name)[found.usable] for name in GROUPS}
