"""The paper's policy for every learned driver: two layers of 256, from features to one number that is an acceleration."""

from pathlib import Path

import torch
from torch import Tensor, nn

from drivegen.drivers.shared.network import FULL_BRAKING, FULL_THROTTLE, perceptron, write_network

WIDTHS, ACTIVATION = (256, 256, 1), "tanh"


class Policy(nn.Module):
    """Features (R, COUNT) -> numbers (R,); `squashed`: tanh bounds them, else `pedals` wants them cut off."""

    def __init__(self, layers: nn.Sequential | None = None, squashed: bool = False) -> None:
        """Without `layers`, which end in one number, new ones of WIDTHS."""
        super().__init__()
        self.layers, self.squashed = layers or perceptron(WIDTHS, ACTIVATION), squashed

    def forward(self, features: Tensor) -> Tensor:
        """What it holds for best."""
        best: Tensor = self.layers(features)[:, 0]
        return best.tanh() if self.squashed else best

    def write(self, folder: Path, name: str) -> None:
        """As the weights of the driver `name`."""
        linear = [layer for layer in self.layers if isinstance(layer, nn.Linear)]
        write_network(folder, name, linear, type(self.layers[1]).__name__.lower(), self.squashed)


class Gaussian(Policy):
    """One that tries others, too; `spread` is the logarithm of the deviation with which it does."""

    def __init__(self, spread: float = -0.7) -> None:
        super().__init__()
        self.spread = nn.Parameter(torch.tensor(spread))

    def likelihood(self, features: Tensor, tried: Tensor) -> Tensor:
        """(R,) logarithm of the density of what was `tried` (R,), up to a constant."""
        away: Tensor = (tried - self(features)) / self.spread.exp()
        return -0.5 * away**2 - self.spread


class Value(nn.Module):
    """Features (R, COUNT) -> what is still to be gained (R,)."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = perceptron(WIDTHS, ACTIVATION)

    def forward(self, features: Tensor) -> Tensor:
        """See the class."""
        value: Tensor = self.layers(features)[:, 0]
        return value


def number_of(acceleration: Tensor) -> Tensor:
    """The inverse of `network.pedals`, in [-1, 1]."""
    return torch.where(acceleration > 0, acceleration / FULL_THROTTLE, acceleration / FULL_BRAKING).clamp(-1.0, 1.0)
