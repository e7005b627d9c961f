"""The others of a world's rows: who moves them (`reactive.py` has those that react), and those that are replayed."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.world.scenes import Scenes

if TYPE_CHECKING:
    from drivegen.world.world import World


@dataclass(frozen=True)
class Boxes:
    """Boxes of the others in the map's frame: row r of the world is row `at[r]` of the arrays.

    Attributes:
        at: (R,) int64. position: (A, M, 2) [m]. heading: (A, M) [rad]. valid: (A, M) bool.
    """

    at: Tensor
    position: Tensor
    heading: Tensor
    valid: Tensor

    def without(self, gone: NDArray[np.bool_]) -> "Boxes":
        """The same, a row of the arrays for each of R rows, in which those of `gone` (R, M) are not there."""
        position, heading, valid = (array[self.at] for array in (self.position, self.heading, self.valid))
        rows = torch.arange(len(gone), device=valid.device)
        return Boxes(rows, position, heading, valid & ~torch.from_numpy(gone).to(valid.device))


class Neighbours(Protocol):
    """Who moves the M others of R rows."""

    def reset(self, world: "World", rows: Tensor | None) -> None:
        """Begin anew in all rows, or in `rows` alone, whose scenes the world has set."""

    def advance(self, world: "World") -> None:
        """Decide on the step that begins; the targets have not moved yet."""

    def seen(self, world: "World") -> tuple[Tensor, Tensor]:
        """Frame (R, 6, M) as in `Replay`, and who is present (R, M)."""

    def rows(self, world: "World") -> Tensor:
        """(R, M) row of the tables of `Scenes` that shows each of them."""

    def boxes(self, world: "World") -> Boxes:
        """Where they are."""


class Replayed:
    """Everybody moves as logged or generated, whatever the target does."""

    def __init__(self, scenes: Scenes) -> None:
        self._scenes = scenes
        arrays = (scenes.replay.position, scenes.replay.heading, scenes.replay.valid)
        self._boxes = [torch.from_numpy(array).flatten(0, 1).to(scenes.steps.device) for array in arrays]

    def reset(self, world: "World", rows: Tensor | None) -> None:
        """See `Neighbours`; nothing is kept of rows."""

    def advance(self, world: "World") -> None:
        """See `Neighbours`; the world's clock is theirs."""

    def seen(self, world: "World") -> tuple[Tensor, Tensor]:
        """See `Neighbours`."""
        at = world.at
        return self._scenes.frame.index_select(0, at), self._scenes.present.index_select(0, at)

    def rows(self, world: "World") -> Tensor:
        """See `Neighbours`."""
        return world.at[:, None].expand(-1, self._scenes.present.shape[1])

    def boxes(self, world: "World") -> Boxes:
        """See `Neighbours`."""
        return Boxes(world.at, *self._boxes)
