"""What is minimised by whoever learns from examples that are found by their numbers: batches, and those held out."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn


class Objective(ABC):
    """See `training.loop.Objective`: the mean loss over examples, in which nothing is random unless `draw` says so.

    Attributes:
        chunk: held-out examples that go through the network at once.
    """

    chunk: ClassVar[int]

    def __init__(self, train: Any, held_out: Any) -> None:
        self.train, self.held_out, self.size = train, held_out, len(train)

    @abstractmethod
    def mean(self, model: nn.Module, examples: Any, rows: NDArray[np.integer], device: torch.device, *drawn: Tensor) -> Tensor:
        """Mean loss over `rows` (b,) of `examples`; what is drawn is not there for those held out."""

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:  # noqa: ARG002 nothing is random
        """See `loop.Objective`."""
        return ()

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        """See `loop.Objective`."""
        return self.mean(model, self.train, rows.cpu().numpy(), rows.device, *drawn)

    def validation(self, model: nn.Module) -> float:
        """See `loop.Objective`."""
        count, device = len(self.held_out), next(model.parameters()).device
        parts = [np.arange(low, min(low + self.chunk, count)) for low in range(0, count, self.chunk)]
        losses = [len(rows) * float(self.mean(model, self.held_out, rows, device)) for rows in parts]
        return sum(losses) / count if count else float("nan")
