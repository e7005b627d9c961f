"""What generators that are trained share: learning from examples, weights on disk, opening by `Plugin(models, settings)`.

Such a generator is one subclass of `Learned` with a network, examples and an objective. It reads the first frame only;
logs are seen by `examples`, in training, alone. It imports neither goals nor planners, so that editing those trains no
rival anew.
"""

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, ClassVar, Protocol, Self

import torch
from torch import Tensor, nn

from drivegen.core import seeds
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Vehicles
from drivegen.core.settings import build
from drivegen.store.columns import Table
from drivegen.training import loop
from drivegen.training.curve import LossRow
from drivegen.training.weights import fill, read_weights, write_weights

Placement = Callable[[Scenario], Vehicles]
"""Vehicles on a scenario's map around its target, as many as it has where there is room; the target comes first."""


class Examples(Table, Protocol):
    """Logged scenarios as arrays to learn from: a table of columns, which may be mapped; only its rows are read, by batches."""

    def __len__(self) -> int:
        """How many there are."""


class Learned(ABC):
    """A generator with trained weights in `models/generators/<name>`; see `generators.base.Generator`.

    Attributes:
        name: the plugin's. Settings: frozen dataclass with a field `training: loop.Settings`, no defaults; its values
            stand in params.yaml, `train_generator.generators.<name>`. Examples: what it learns from.
        about: its ABOUT. backend: it chooses no goals.
        tempered: whether it draws from `p ** (1 / temperature)`, normalised: then `tune` sets the temperature, no settings do.
        settings, net: how it was made, and the trained network on the CPU in evaluation mode.
    """

    name: ClassVar[str]
    Settings: ClassVar[type]
    Examples: ClassVar[type[Examples]]
    about: ClassVar[Method]
    backend = "none"
    tempered: ClassVar[bool] = False

    settings: Any
    net: nn.Module

    def __init__(self, models: Path, settings: object) -> None:
        """Open the weights; `settings`, of DriveGen's own generation, concern none of them.

        Raises MissingTool where the weights are absent, UnusableInput where they are damaged or do not fit.
        """
        del settings
        folder = models / "generators" / self.name
        values, tensors = read_weights(folder, "generator", self.name)
        self.settings = build(self.Settings, values, f"{folder}")
        self.net = self._untrained(self.settings)
        fill(self.net, tensors, folder)
        self._ready()

    @classmethod
    @abstractmethod
    def network(cls, settings: Any) -> nn.Module:
        """The untrained network; everything that is learnt, scales included, is a parameter or a buffer of it."""

    @classmethod
    @abstractmethod
    def examples(cls, settings: Any, scenarios: Sequence[Scenario]) -> Any:
        """An `Examples` of the scenarios that have a log."""

    @classmethod
    @abstractmethod
    def objective(cls, settings: Any, net: Any, train: Any, validation: Any, seed: int) -> loop.Objective:
        """What is minimised; may set buffers of `net` (already on its device) from the train examples."""

    @abstractmethod
    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """See `generators.base.Generator`."""

    @classmethod
    def fit(
        cls,
        settings: Any,
        train: Any,
        validation: Any,
        seed: int,
        checkpoints: Path | None,
        report: Callable[[str], None],
        rolled: Callable[[Self], float] | None = None,
    ) -> tuple[Self, list[LossRow]]:
        """The trained generator and its loss curve; the weights of `curve.kept` are kept.

        `rolled` is the error [m] of a generator's roll-outs, asked at every row: whose error is least is kept. The loss of one
        step is no guide to that, some are lowest before anything is learnt. Without `rolled` the validation loss decides.
        Its temperature is 1 until `tune` is asked.

        Same arguments, same weights, also when killed and started again: `checkpoints` is a folder for interrupted
        work, named by the caller after all inputs; `report` takes progress lines. Raises UnusableInput where there is
        nothing to learn from.
        """
        torch.manual_seed(seeds.derive(seed, "network", cls.name))
        net = cls._untrained(settings).to(loop.device())
        path = None if checkpoints is None else checkpoints / f"{cls.name}.safetensors"
        objective = cls.objective(settings, net, train, validation, seed)

        def probe(averaged: nn.Module) -> float:
            return float("nan") if rolled is None else rolled(cls._with(settings, copy.deepcopy(averaged)))

        best, curve = loop.train(net, objective, settings.training, seed, path, report, keep_best=True, probe=probe)
        return cls._with(settings, best), curve

    @property
    def temperature(self) -> Tensor:
        """Of the odds that it draws from, where it is `tempered`: a number that is kept with the weights."""
        return self.net.get_buffer("temperature")

    def tune(
        self, temperatures: Sequence[float], rolled: Callable[[Self], Mapping[str, float]], counted: Sequence[str]
    ) -> dict[float, Mapping[str, float]]:
        """Errors of its roll-outs at each temperature, {} unless it is `tempered`.

        Keeps the temperature of the least sum of the errors `counted`: the first of equals, and the first where there are none.
        """
        found: dict[float, Mapping[str, float]] = {}
        for temperature in temperatures if self.tempered else ():
            self.temperature.fill_(temperature)
            found[temperature] = rolled(self)
        if found:
            self.temperature.fill_(min(found, key=lambda tried: sum(found[tried].get(name, math.inf) for name in counted)))
        return found

    @classmethod
    def _untrained(cls, settings: Any) -> nn.Module:
        """Its network, with the temperature where it has one."""
        net = cls.network(settings)
        if cls.tempered:
            net.register_buffer("temperature", torch.ones((), dtype=torch.float64))
        return net

    @classmethod
    def _with(cls, settings: Any, net: nn.Module) -> Self:
        """The generator of a network, which goes to the CPU."""
        made = cls.__new__(cls)
        made.settings, made.net = settings, net.cpu()
        made._ready()
        return made

    def bounds(self) -> "dict[str, Learned]":
        """By their own names, generators with these very weights that are told some of what happened: bounds, no methods."""
        return {}

    def placements(self, logs: Iterable[Scenario], seed: int) -> dict[str, Placement]:
        """Its ways to place vehicles, a bound's among them, by their titles in tables; none unless `Method.places`.

        `logs` of the train split may be drawn from.
        """
        del logs, seed
        return {}

    def save(self, folder: Path) -> None:
        """Write settings (JSON) and weights (safetensors) into `folder`, that is `models/generators/<name>`."""
        tensors = {key: value.numpy() for key, value in self.net.state_dict().items()}
        write_weights(folder, "generator", self.name, asdict(self.settings), tensors)

    @property
    def parameters(self) -> int:
        """How many numbers were learnt."""
        return sum(p.numel() for p in self.net.parameters())

    def _ready(self) -> None:
        torch.set_num_threads(1)  # sums depend on the number of threads
        self.net.eval().requires_grad_(False)
