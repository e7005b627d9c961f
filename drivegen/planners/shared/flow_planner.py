"""What planners by flow matching share: learning the flow of low-rank residuals, drawing from it, weights in and out.

A planner says how logged tracks become features and spline coefficients, by group of residuals (`_encoded`), what its network
is (`_new_net`), and how latents that were drawn become motion again (`_planned`).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, ClassVar, Generic, Self, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import Count, Share, Within, build
from drivegen.planners.base import Examples, PlanRequests
from drivegen.planners.shared.flow import FlowNet, FlowObjective
from drivegen.planners.shared.latent import Basis, draw, importance, principal, whitened
from drivegen.planners.shared.noise import normals
from drivegen.planners.shared.profile import COEFFICIENTS
from drivegen.planners.shared.scores import drawn_tracks, probe
from drivegen.store.columns import Columns
from drivegen.training import loop
from drivegen.training.curve import LossRow
from drivegen.training.weights import fill, read_weights, write_weights

WATCHED = 200
"""Validation tracks that are planned at each row of the loss curve."""

Coefficients = dict[str, NDArray[np.float64]]
"""Spline coefficients (E, C) of each group of residuals, in the groups' order."""

Components = Annotated[int, Within(1, COEFFICIENTS)]
"""Principal components that are kept of a group."""


@dataclass(frozen=True)
class FlowSettings:
    """Values stand in params.yaml, `train_planner.planners`.

    Attributes:
        width, blocks, dropout: of the flow's network. draws: noises per example and training step.
        euler_steps: steps when sampling: 2 for the least error, 8 for the truest spread.
        training: see `training.loop.Settings`.
    """

    width: Count
    blocks: Count
    dropout: Share
    draws: Count
    euler_steps: Count
    training: loop.Settings


S = TypeVar("S", bound=FlowSettings)


@dataclass(frozen=True)
class _Inputs:
    """Features (E, F)."""

    rows: NDArray[np.float32]

    @classmethod
    def none(cls) -> Self:
        return cls(np.zeros((0, 0), np.float32))


@dataclass(frozen=True)
class _Fitted:
    """Spline coefficients (E, C) of a group."""

    rows: NDArray[np.float64]

    @classmethod
    def none(cls) -> Self:
        return cls(np.zeros((0, 0)))


class FlowPlanner(ABC, Generic[S]):
    """See `planners.base.Planner`; `name` is the plugin's, `keeps` what tracks must do to be learnt from, in words."""

    name: ClassVar[str]
    keeps: ClassVar[str]
    Settings: type[S]

    def __init__(self, settings: S) -> None:
        self.settings = settings
        self.basis: Basis = {}
        self.net = self._new_net()
        self.learnt_from = 0

    def fit(
        self, train: Iterable[Examples], validation: Examples, seed: int, checkpoints: Path | None, report: Callable[[str], None]
    ) -> list[LossRow]:
        """See `planners.base.Planner`. Raises UnusableInput where fewer tracks move than there are components."""
        inputs, coefficients, tracks_seen = self._all_encoded(train, checkpoints)
        held_inputs, held = self._encoded(validation)
        counts, settings, device = self._coefficient_counts(), self.settings, loop.device()
        if len(inputs) < max(counts.values()):
            raise UnusableInput(f"only {len(inputs)} logged tracks move: too few to learn from", reason="no-examples")
        self.basis = {}
        for group, count in counts.items():
            self.basis |= principal(coefficients[group], count, group)
        torch.manual_seed(seeds.derive(seed, "network"))
        net = self._new_net().to(device)
        objective = FlowObjective(
            torch.from_numpy(inputs).to(device), whitened(coefficients, self.basis, checkpoints).to(device),
            importance(tuple(counts), self.basis).to(device), settings.draws,
            (torch.from_numpy(held_inputs).to(device), whitened(held, self.basis).to(device)), seeds.derive(seed, "validation"),
        )  # fmt: skip
        path = None if checkpoints is None else checkpoints / f"{self.name}.safetensors"
        report(f"{len(inputs)} of {tracks_seen} logged tracks move and keep {self.keeps}")
        tracks = drawn_tracks(validation, WATCHED, None, seed)

        def watched(net: FlowNet) -> float:
            self.net = net
            return probe(self.sample, validation, tracks, seed)

        self.learnt_from = objective.size
        averaged, curve = loop.train(net, objective, settings.training, seed, path, report, probe=watched)
        self.net = averaged.cpu().eval()
        return curve

    def _all_encoded(self, train: Iterable[Examples], folder: Path | None) -> tuple[NDArray[np.float32], Coefficients, int]:
        """`_encoded` of all parts, mapped from files of `folder`, and how many tracks were gone through."""
        inputs, tracks = Columns(_Inputs, folder), 0
        coefficients = {group: Columns(_Fitted, folder) for group in self._coefficient_counts()}
        for part in train:
            told, fitted = self._encoded(part)
            tracks += len(part)
            inputs.add(_Inputs(told))
            for group, columns in coefficients.items():
                columns.add(_Fitted(fitted[group]))
        return inputs.whole().rows, {group: columns.whole().rows for group, columns in coefficients.items()}, tracks

    def sample(self, scenarios: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        """See `planners.base.Planner`. Raises UnusableInput if it was never trained."""
        if not self.basis:
            raise UnusableInput(f"planner {self.name} has not been trained", reason="untrained")
        if not len(requests):  # loops would be compiled for arrays of nothing
            return Trajectories.empty(0, 1)
        horizon = np.array([s.steps for s in scenarios])[requests.scenario]
        motion = self._planned(scenarios, requests, int(horizon.max(initial=1)))
        motion.valid[:] = np.arange(motion.steps) < horizon[:, None]
        return motion

    def save(self, folder: Path) -> None:
        """See `planners.base.Planner`."""
        tensors = {f"net/{k}": v.cpu().numpy() for k, v in self.net.state_dict().items()}
        tensors |= {f"basis/{k}": v for k, v in self.basis.items()}
        write_weights(folder, "planner", self.name, asdict(self.settings), tensors)

    @classmethod
    def load(cls, folder: Path) -> Self:
        """See `planners.base.Planner`."""
        values, tensors = read_weights(folder, "planner", cls.name)
        planner = cls(build(cls.Settings, values, f"{folder}"))
        planner.basis = {k.removeprefix("basis/"): v for k, v in tensors.items() if k.startswith("basis/")}
        fill(planner.net, {k.removeprefix("net/"): v for k, v in tensors.items() if k.startswith("net/")}, folder)
        planner.net.eval()
        return planner

    def _latents(self, inputs: NDArray[np.float32], requests: PlanRequests) -> NDArray[np.float32]:
        """Latents (B, Z) of requests from what the network is told of them (B, F)."""
        return draw(self.net, inputs, normals(requests.seed, self.size), self.settings.euler_steps)

    @property
    def size(self) -> int:
        """Z: latents of all groups together, an even number."""
        return sum(self._coefficient_counts().values())

    @property
    def euler_steps(self) -> int:
        """Steps when sampling."""
        return self.settings.euler_steps

    def in_steps(self, euler_steps: int) -> Self:
        """The same planner with so many steps when sampling."""
        other = copy(self)
        other.settings = replace(self.settings, euler_steps=euler_steps)
        return other

    @abstractmethod
    def _coefficient_counts(self) -> dict[str, int]:
        """Principal components that are kept, by group."""

    @abstractmethod
    def _new_net(self) -> FlowNet:
        """The network before training."""

    @abstractmethod
    def _encoded(self, examples: Examples) -> tuple[NDArray[np.float32], Coefficients]:
        """Features (E, F) and coefficients of the tracks that can be learnt from."""

    @abstractmethod
    def _planned(self, scenarios: Sequence[Scenario], requests: PlanRequests, steps: int, /) -> Trajectories:
        """Motion (B, steps) of the requests."""
