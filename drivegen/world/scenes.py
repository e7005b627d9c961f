"""Scenes with their traffic, packed once as tensors on one device, so that a batch of them is an index."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.world.observation import PATH_SPACING, Paths
from drivegen.world.paths import TargetPaths, target_paths
from drivegen.world.replay import Replay, replay


@dataclass(frozen=True)
class Scenes:
    """S scenes of at most T steps, each with a target on its path and M others.

    Attributes:
        replay: the others and the targets' first states, in arrays.
        paths: Paths of the S targets.
        frame: (S * T, 6, M) and present: (S * T, M) as in `Replay`; row s * T + t is scene s at step t.
        steps: (S,) int64 steps of each scene.
        size: (S, 2) [m] of the targets. others_size: (S, M, 2) [m].
        speed: (S,) [m/s] of the targets at step 0, start: their positions (S, 2) [m] and headings (S,) [rad].
    """

    replay: Replay
    paths: Paths
    frame: Tensor
    present: Tensor
    steps: Tensor
    size: Tensor
    others_size: Tensor
    speed: Tensor
    start: tuple[Tensor, Tensor]

    @classmethod
    def of(
        cls,
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths | None = None,
        rows: int | None = None,
        device: torch.device | str = "cpu",
    ) -> Self:
        """Pack scenarios with their `traffic` (N, T); up to `rows` the rest are empty scenes, so that a shape can be kept.

        About 150 kB a scene of 32 others and 101 steps. Raises UnusableInput for a target that is not there at step 0.
        """
        rows = rows or len(scenarios)
        paths = paths if paths is not None else target_paths(scenarios, traffic)
        return cls.packed(replay(scenarios, traffic, paths, rows), _tensors(paths, rows, device), device)

    @classmethod
    def packed(cls, others: Replay, paths: Paths, device: torch.device | str = "cpu") -> Self:
        """From arrays of S scenes and the paths of their targets."""

        def tensor(array: NDArray[Any]) -> Tensor:
            return torch.from_numpy(array).to(device)

        return cls(
            others,
            paths,
            frame=tensor(others.frame).flatten(0, 1),
            present=tensor(others.valid).flatten(0, 1),
            steps=tensor(others.steps),
            size=tensor(others.target_size),
            others_size=tensor(others.size),
            speed=tensor(others.target_speed),
            start=(tensor(others.target_position), tensor(others.target_heading)),
        )

    def exchanged(
        self, chosen: NDArray[np.intp], row: NDArray[np.integer], vehicle: NDArray[np.integer], motion: Trajectories
    ) -> "Scenes":
        """Scenes `chosen` (R,), copied, in which `vehicle` (E,) of copy `row` (E,) moves as `motion` (E, T)."""
        others, device = self.replay[chosen], self.steps.device
        used = np.unique(chosen[row])
        line = {s: self.paths.point[s, : int(self.paths.length[s] / PATH_SPACING) + 1].cpu().numpy() for s in used.tolist()}
        others.exchange(row, vehicle, motion, [line[s] for s in chosen[row].tolist()])
        return self.packed(others, self.paths[torch.from_numpy(chosen).to(device)], device)

    def __len__(self) -> int:
        return len(self.steps)

    @property
    def longest(self) -> int:
        """T."""
        return int(self.replay.valid.shape[1])


def _tensors(paths: TargetPaths, rows: int, device: torch.device | str) -> Paths:
    """The paths as tensors, with the last one repeated up to `rows`."""
    index = np.minimum(np.arange(rows), len(paths) - 1)
    point = torch.from_numpy(paths.point[index])
    step = point[:, 1:] - point[:, :-1]
    heading = torch.atan2(step[..., 1], step[..., 0])
    length = torch.from_numpy(paths.length[index])
    last = length.long() - 1  # beyond it points repeat and have no direction
    column = torch.minimum(torch.arange(point.shape[1])[None], last[:, None])
    limit = torch.from_numpy(paths.speed_limit[index])
    return Paths(*(tensor.to(device) for tensor in (point, heading.gather(1, column), limit, length)))
