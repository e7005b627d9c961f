"""What planner `paper` is trained on: rasters drawn when they are needed, and the diffusion loss."""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core.scenario import Scenario
from drivegen.planners._paper.states import conditions, to_states
from drivegen.planners.base import Examples, PlanRequests
from drivegen.roads.raster import RasterMap, raster

HELD_OUT = 256
"""Validation examples that the loss is taken over, the first ones; rasters make each dear."""

HELD_OUT_CHUNK = 32


class Rasters:
    """Rasters of requests' vehicles; each scenario's map is made ready once."""

    def __init__(self, scenarios: Sequence[Scenario], channels: Sequence[str], extent: float) -> None:
        self.scenarios, self.channels, self.extent = scenarios, channels, extent
        self.ready: dict[int, RasterMap] = {}

    def of(self, requests: PlanRequests) -> NDArray[np.uint8]:
        """(B, C, 256, 256)."""
        rows = zip(requests.scenario.tolist(), requests.position, requests.heading.tolist(), strict=True)
        pictures = [raster(self._map(s), position, heading, self.extent, self.channels) for s, position, heading in rows]
        return np.stack(pictures)

    def _map(self, scenario: int) -> RasterMap:
        if scenario not in self.ready:
            self.ready[scenario] = RasterMap.of(self.scenarios[scenario].map)
        return self.ready[scenario]


class DiffusionObjective:
    """Mean squared error of the predicted noise (or clean states) at a random diffusion step.

    A row of a batch is one trajectory or, with `batch_of` "scenarios", all trajectories of one scenario.
    """

    def __init__(
        self,
        train: Examples,
        validation: Examples,
        alpha_bar: Tensor,
        target: str,
        state: str,
        tokens: int,
        batch_of: str,
        channels: Sequence[str],
        extent: float,
        seed: int,
    ) -> None:
        self.alpha_bar, self.target = alpha_bar, target
        self.train = _Set(train, state, tokens, channels, extent)
        self.held_out = _Set(validation[: min(HELD_OUT, len(validation))], state, tokens, channels, extent)
        self.members = _members(train.requests.scenario, batch_of)
        self.size = len(self.members)
        self.seed = seed

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """Noise (rows, V, T, S) and diffusion steps (rows, V) for up to V trajectories per row."""
        shape = (rows, self.members.shape[1])
        noise = torch.randn(*shape, *self.train.states.shape[1:], generator=generator)
        return noise, torch.randint(len(self.alpha_bar), shape, generator=generator)

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        """Mean over all trajectories of the rows."""
        members = self.members[rows.cpu().numpy()]
        there = members >= 0
        mask = torch.from_numpy(there).to(drawn[0].device)
        return self._error(model, self.train, members[there], drawn[0][mask], drawn[1][mask])

    def validation(self, model: nn.Module) -> float:
        """The same on the first HELD_OUT validation examples, with the same noise every time."""
        count = len(self.held_out.states)
        if count == 0:
            return float("nan")
        generator = torch.Generator().manual_seed(self.seed)
        total = 0.0
        for low in range(0, count, HELD_OUT_CHUNK):
            rows = np.arange(low, min(low + HELD_OUT_CHUNK, count))
            noise = torch.randn(len(rows), *self.held_out.states.shape[1:], generator=generator)
            step = torch.randint(len(self.alpha_bar), (len(rows),), generator=generator)
            device = self.alpha_bar.device
            total += len(rows) * float(self._error(model, self.held_out, rows, noise.to(device), step.to(device)))
        return total / count

    def _error(self, model: nn.Module, examples: "_Set", rows: NDArray[np.integer], noise: Tensor, step: Tensor) -> Tensor:
        clean, start, goal, pictures = (a.to(noise.device) for a in examples.tensors(rows))
        level = self.alpha_bar[step][:, None, None]
        noisy = level.sqrt() * clean + (1 - level).sqrt() * noise
        output = model(noisy, start, goal, pictures, step)
        return torch.as_tensor((output.float() - (noise if self.target == "noise" else clean)).square().mean())


class _Set:
    """Examples as arrays: clean states (E, T, S), initial states and goals (E, S), and rasters on demand."""

    def __init__(self, examples: Examples, state: str, tokens: int, channels: Sequence[str], extent: float) -> None:
        self.requests = examples.requests
        self.states = to_states(examples.motion, examples.requests, state, tokens)
        self.start, self.goal = conditions(examples.requests, state)
        self.rasters = Rasters(examples.scenarios, channels, extent)

    def tensors(self, rows: NDArray[np.integer]) -> tuple[Tensor, ...]:
        pictures = self.rasters.of(self.requests[rows])
        return tuple(torch.from_numpy(a) for a in (self.states[rows], self.start[rows], self.goal[rows], pictures))


def _members(scenario: NDArray[np.int32], batch_of: str) -> NDArray[np.int64]:
    """(rows, V) example numbers of each row of a batch, -1 where it has fewer than V."""
    if batch_of == "trajectories" or len(scenario) == 0:
        return np.arange(len(scenario))[:, None]
    groups = [np.flatnonzero(scenario == s) for s in np.unique(scenario)]
    members = np.full((len(groups), max(map(len, groups))), -1)
    for row, group in zip(members, groups, strict=True):
        row[: len(group)] = group
    return members
