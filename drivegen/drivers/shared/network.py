"""Drivers that are networks: a multilayer perceptron on `features`, whose weights are safetensors in a folder.

Such a driver is a file of `drivegen/drivers`, as docs/drivers.md shows; `gym.sb3.save_policy` writes its weights.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.features import COUNT, VERSION, features
from drivegen.training.weights import fill, read_weights, write_weights
from drivegen.world.observation import Action, Observation

KIND = "driver"

FULL_THROTTLE, FULL_BRAKING, FARTHEST_OFFSET = 3.0, 8.0, 1.5
"""[m/s2], [m/s2] and [m] that -1 and 1 stand for."""

_ACTIVATIONS: dict[str, type[nn.Module]] = {"tanh": nn.Tanh, "relu": nn.ReLU}


def pedals(number: Tensor) -> Tensor:
    """Accelerations [m/s2] from numbers in [-1, 1]."""
    return torch.where(number > 0, FULL_THROTTLE * number, FULL_BRAKING * number)


def on_path(numbers: Tensor) -> Action:
    """What S targets do on their paths, from numbers (S, 1 or 2) in [-1, 1]: acceleration, and offset where there are two."""
    return Action(pedals(numbers[:, 0]), FARTHEST_OFFSET * numbers[:, 1] if numbers.shape[1] > 1 else None)


@dataclass(frozen=True)
class Settings:
    """`weights`: the folder of them. `sees_rules`: whether it was trained to look at signals and right of way."""

    weights: str
    sees_rules: bool


class Network:
    """A driver by its weights; subclasses give it a name."""

    name: str
    settings_type: ClassVar[type] = Settings

    def __init__(self, settings: Settings) -> None:
        """Raises MissingTool where there are no weights, UnusableInput where they are another driver's, older or damaged."""
        folder = Path(settings.weights)
        about, tensors = read_weights(folder, KIND, self.name)
        if (version := about.get("features", 1)) != VERSION:
            raise UnusableInput(
                f"{folder}: these weights learned from features of version {version}, not {VERSION}: train them anew"
            )
        self.sees_rules, self._squashed = settings.sees_rules, bool(about.get("squashed"))
        try:
            self._net = perceptron(about["widths"], about["activation"])
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            raise UnusableInput(f"{folder}: settings.json describes no network ({error}): train it again") from None
        fill(self._net, tensors, folder)

    @torch.no_grad()
    def act(self, observation: Observation) -> Action:
        """The policy's mean."""
        seen = features(observation)
        numbers = self._net.to(seen.device)(seen)
        return on_path(numbers.tanh() if self._squashed else numbers.clamp(-1.0, 1.0))


def perceptron(widths: Sequence[int], activation: str) -> nn.Sequential:
    """COUNT numbers in, linear layers of `widths` with an activation between them; raises ValueError for an unknown one."""
    if activation not in _ACTIVATIONS or not widths:
        raise ValueError(f"activation {activation!r}, widths {list(widths)}")
    layers: list[nn.Module] = []
    for before, after in zip([COUNT, *widths], widths, strict=False):
        layers += [nn.Linear(before, after), _ACTIVATIONS[activation]()]
    return nn.Sequential(*layers[:-1])


def write_network(folder: Path, name: str, linear: Sequence[nn.Linear], activation: str, squashed: bool) -> None:
    """Write linear layers as the weights of the driver `name`; `squashed`: tanh bounds its output, else it is cut off."""
    net = perceptron([layer.out_features for layer in linear], activation)
    rows = [layer for layer in net if isinstance(layer, nn.Linear)]
    for own, source in zip(rows, linear, strict=True):
        own.load_state_dict(source.state_dict())
    tensors: Mapping[str, NDArray[Any]] = {key: tensor.numpy() for key, tensor in net.state_dict().items()}
    widths = [layer.out_features for layer in linear]
    settings = {"widths": widths, "activation": activation, "squashed": squashed, "features": VERSION}
    write_weights(folder, KIND, name, settings, tensors)
