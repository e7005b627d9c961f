"""Learned generators that drive in closed loop: vehicles see, go on by a part of what is planned, and see again."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import expect_multiple
from drivegen.generators.shared.closed_loop import Crowd, Tracks
from drivegen.generators.shared.learned import Learned

SCENES = 16
"""Scenarios that are driven on together; bounds memory."""

Ask = Callable[[NDArray[np.integer]], Sequence[Tensor]]
"""What a network says of some boxes or rows: tensors, a row each."""

Draw = Callable[..., NDArray[np.float64]]
"""`draw(*shape)` are fresh numbers (R, *shape) in [0, 1), those of a scenario from its own stream."""


@dataclass(frozen=True)
class Agents:
    """The R vehicles of tracks that hold copies of scenes side by side, alike at step 0.

    Attributes:
        box: (R,). first: (F,) boxes in the first copies. alike: (R,) the number among `first` of the one that each is a copy of.
    """

    box: NDArray[np.int64]
    first: NDArray[np.int64]
    alike: NDArray[np.int64]

    @classmethod
    def of(cls, tracks: Tracks, copies: int) -> Self:
        """All that are planned, copy by copy."""
        box = np.flatnonzero(tracks.planned)
        copy = tracks.scene(box)
        within = box - tracks.start[copy]
        number = copy // copies * (within.max(initial=0) + 1) + within
        _, first, alike = np.unique(number, return_index=True, return_inverse=True)
        return cls(box, box[first], alike.reshape(-1))

    def asked(self, crowd: Crowd, size: int, ask: Ask) -> list[Tensor]:
        """What `ask` says of each, see `in_chunks`; at step 0 the first copy stands for all."""
        if crowd.step.any():
            return in_chunks(self.box, size, ask)
        return [part[torch.from_numpy(self.alike)] for part in in_chunks(self.first, size, ask)]


def in_chunks(rows: NDArray[np.integer], size: int, ask: Ask) -> list[Tensor]:
    """What `ask` says of `rows`, always of `size` at once, since sums differ between batch sizes: the last chunk is filled up."""
    chunks = [rows[low : low + size] for low in range(0, len(rows), size)]
    parts = [[said[: len(chunk)] for said in ask(np.resize(chunk, size))] for chunk in chunks]
    return [torch.cat(part) for part in zip(*parts, strict=True)]


class ClosedLoop(Learned):
    """Its settings say by `commit` how many steps are driven before everybody sees again.

    Attributes:
        chunk: vehicles that go through the network at once, always.
    """

    chunk: ClassVar[int]

    @abstractmethod
    def roads(self, scenarios: Sequence[Scenario]) -> Any:
        """The maps of scenarios as the network is told them."""

    @abstractmethod
    def planned(self, roads: Any, agents: Agents, crowd: Crowd, draw: Draw) -> Trajectories:
        """How the agents (R,) of a crowd go on, (R, commit)."""

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` futures of each scenario."""
        made = []
        with torch.inference_mode():
            for low in range(0, len(scenarios), SCENES):
                made += self._driven(scenarios[low : low + SCENES], samples, seed)
        return made

    def _driven(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        roads, tracks = self.roads(scenarios), Tracks.of_beginnings(scenarios, samples)
        agents, copies = Agents.of(tracks, samples), np.arange(len(scenarios) * samples)
        streams = [(seeds.rng(seed, self.name, s.scenario_id), samples * len(s.vehicles)) for s in scenarios]

        def draw(*shape: int) -> NDArray[np.float64]:
            return np.concatenate([stream.random((count, *shape)) for stream, count in streams])

        for step in range(0, tracks.valid.shape[1] - 1, self.settings.commit):
            crowd = tracks.at(copies, np.full(len(copies), step), samples)
            tracks.drive(agents.box, step, self.planned(roads, agents, crowd, draw))
        return tracks.samples(scenarios, samples, self.name)


def expect_commits(place: str, horizon: int, commit: int, every: int) -> None:
    """Raise UnusableInput unless `commit` is at most `horizon`, and both settings of `place` are multiples of `every`."""
    for name, steps in (("horizon", horizon), ("commit", commit)):
        expect_multiple(f"{place}.{name}", steps, every)
    if commit > horizon:
        raise UnusableInput(f"{place}.commit must be at most horizon, {horizon}, not {commit}")
