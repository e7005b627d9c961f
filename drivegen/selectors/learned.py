"""The default selector: a small listwise ranker that imitates logs. It is not a language model and does not pretend to be.

Trained on the train split's logs: cross-entropy between the softmax over a vehicle's candidates and the soft label
exp(-d^2 / 2 sigma^2), d the distance from the logged end, sigma wider for vehicles that left the scene before. The weights
of the lowest validation loss are kept; then one temperature is set on the validation split so that
its probabilities mean what they say. A share `floor` of them follows the hand-made prior: on roads and drivers unlike those
learnt from no ranker should be surer than that. Every log is learnt from twice, the second time without signals, rules of
way and, half of the times, limits, as data sets without these layers have it (`core.twins`); so do all learned generators that
DriveGen is compared with. The ranker may also be taught by another selector's recorded odds; its description then says whose.

In the simulated corpus whoever is parked stays for good, and few are: who is parked (`roads.parked`) is taken to stay by rule, as
the rival `idm` takes it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count, NotNegative, Positive, Share
from drivegen.goals.candidates import Candidates
from drivegen.goals.features import NAMES, features
from drivegen.goals.lists import Lists, Padded, Padding
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.roads.graph import LaneGraph
from drivegen.roads.parked import parked
from drivegen.selectors._ranker import Ranker
from drivegen.selectors.base import FirstFrameSelector
from drivegen.store.columns import Columns, Starts
from drivegen.store.lookup import evenly
from drivegen.training.curve import LossRow
from drivegen.training.loop import Settings as Training
from drivegen.training.loop import train
from drivegen.training.weights import fill, read_weights, write_weights

KIND, NAME = "goal selector", "learned"
"""As they stand in the settings beside the weights."""

DRAWN = 4
"""Goals of each vehicle that are drawn to tell how good weights are, as many as rivals' futures (train_generator.watched)."""

CHUNK = 64
"""Lists are ranked in chunks of this many, padded, so that a result does not depend on its neighbours."""

PARKED_STAYS = 0.9
"""Who is parked stays with at least this probability."""

HELD_OUT = 8192
"""Of more validation lists so many are asked about, evenly spread."""

LABELLED = 4096
"""Lists are labelled in chunks of this many."""

TEMPERATURES = np.exp(np.linspace(-1.0, 1.5, 51))
"""Tried on the validation split."""


@dataclass(frozen=True)
class Settings:
    """How to learn.

    Attributes:
        width: of the layers. dropout: share of their outputs. sigma: [m] width of the soft label. farthest: [m] lists
            whose nearest candidate is farther from the logged end are left out; a doubtful end may be farther away.
        floor: share of the probability that is the candidates' prior. training: the loop's settings.
    """

    width: Count
    dropout: Share
    sigma: Positive
    farthest: NotNegative
    floor: Share
    training: Training

    def __post_init__(self) -> None:
        if not 0 <= self.floor < 1:
            raise UnusableInput(f"train_selector.learned: floor is a share below 1, not {self.floor:g}")


class Plugin(FirstFrameSelector):
    """The trained ranker."""

    described = "learned selector (imitates logs)"

    def __init__(self, net: Ranker, floor: float = 0.0, known: Sequence[str] = NAMES, described: str = "") -> None:
        """`known` are the features that the net was trained on, `described` who taught it if not logs."""
        torch.set_num_threads(1)  # sums depend on the number of threads
        self.net, self.floor = net.eval().requires_grad_(False), floor
        self.described = described or self.described
        self._columns = [NAMES.index(name) for name in known]

    @classmethod
    def fit(
        cls,
        learnt: Lists,
        held_out: Lists,
        settings: Settings,
        seed: int,
        checkpoint: Path | None,
        report: Callable[[str], None],
        teacher: str = "",
    ) -> tuple[Self, list[LossRow]]:
        """Learn from `learnt`, calibrate on `held_out` (on `learnt` where that is empty); the loss curve beside it.

        `teacher` names whose odds `learnt` are labelled with, "" for logs.

        Raises UnusableInput where there is nothing to learn from.
        """
        torch.manual_seed(seeds.derive(seed, "ranker"))
        net = Ranker(len(NAMES), settings.width, settings.dropout)
        objective = _Listwise(learnt, held_out, settings, None if checkpoint is None else checkpoint.parent)
        if objective.size:
            rows = torch.from_numpy(objective.learnt.x)
            net.mean.copy_(rows.mean(0))
            net.scale.copy_(rows.std(0).clamp(min=0.05))
        net, curve = train(
            net, objective, settings.training, seed, checkpoint, report, keep_best=True, probe=objective.goal_distance
        )
        calibration = objective.learnt.some(HELD_OUT) if len(held_out) == 0 else objective.held_out
        net.temperature.fill_(_temperature(net.eval(), calibration, settings.floor))
        return cls(net, settings.floor, described=f"learned selector (distilled from {teacher})" if teacher else ""), curve

    def rank(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[NDArray[np.float32]]:
        """Calibrated probabilities, raised for staying where a vehicle is parked."""
        pad = Padding.of(np.cumsum([0, *map(len, candidates)]), np.arange(len(candidates)))
        x = np.concatenate(features(first_frame(scenario), candidates))[:, self._columns]  # as it has learnt
        lists = pad(x), pad.there, pad(np.concatenate([c.prior for c in candidates]))
        chunks = [self._chunk(*(a[i : i + CHUNK] for a in lists)) for i in range(0, len(candidates), CHUNK)]
        odds = [p[: len(c)] for p, c in zip(np.concatenate(chunks), candidates, strict=True)]
        stays = parked(graph, scenario.vehicles)[: len(odds)]
        return [_staying(p, c) if stay else p for p, c, stay in zip(odds, candidates, stays, strict=True)]

    def _chunk(self, *lists: NDArray[np.generic]) -> NDArray[np.float32]:
        """Probabilities (b, MOST) of x, there and prior of at most CHUNK lists, computed at full size."""
        count = len(lists[0])
        x, there, prior = (torch.from_numpy(np.pad(a, [(0, CHUNK - count)] + [(0, 0)] * (a.ndim - 1))) for a in lists)
        return _floored(self.net(x, there), prior, float(self.net.temperature), self.floor)[:count].numpy()

    def save(self, folder: Path) -> None:
        """Weights as safetensors, and what they belong to; equal weights give equal bytes.

        Raises UnusableInput where a weight is not finite.
        """
        known = [NAMES[column] for column in self._columns]
        about = {"described": self.described, "features": known, "width": self.net.each[0].out_features, "floor": self.floor}
        write_weights(folder, KIND, NAME, about, {name: tensor.numpy() for name, tensor in self.net.state_dict().items()})

    @classmethod
    def load(cls, folder: Path) -> Self:
        """What `save` wrote. Raises MissingTool where there are no weights, UnusableInput where they are not ours."""
        about, tensors = read_weights(folder, KIND, NAME)
        known = tuple(about["features"])
        if not set(known) <= set(NAMES):
            raise UnusableInput(f"{folder} was trained on other features: run the train_selector stage again")
        net = Ranker(len(known), about["width"])
        fill(net, tensors, folder)
        return cls(net, about["floor"], known, about["described"])


_Tensors = tuple[Tensor, Tensor, Tensor, Tensor, Tensor]
"""x (B, MOST, F), there, soft label, prior and distance [m] (B, MOST) of lists."""


@dataclass(frozen=True)
class _Taught:
    """Lists that have a candidate near enough, end to end, with their soft labels; a table of columns."""

    start: Annotated[NDArray[np.int64], Starts("x")]
    x: NDArray[np.float32]
    label: NDArray[np.float32]
    prior: NDArray[np.float32]
    distance: NDArray[np.float32]

    @classmethod
    def none(cls) -> Self:
        none = Lists.none()
        return cls(none.start, none.x, none.prior, none.prior, none.distance)

    @classmethod
    def of(cls, lists: Lists, settings: Settings, folder: Path | None) -> Self:
        """Mapped from files of `folder` where one is named."""
        columns = Columns(cls, folder)
        for low in range(0, len(lists), LABELLED):
            columns.add(cls._of(lists.padded(np.arange(low, min(low + LABELLED, len(lists)))), settings))
        return columns.whole()

    @classmethod
    def _of(cls, lists: Padded, settings: Settings) -> Self:
        near = lists.distance.min(1, initial=np.inf) <= settings.farthest + lists.doubt
        distance, doubt = lists.distance[near].astype(np.float64), lists.doubt[near, None].astype(np.float64)
        label = np.exp(-(distance**2 - distance.min(1, keepdims=True) ** 2) / (2 * (settings.sigma**2 + doubt**2)))
        taught, there = lists.taught[near], lists.there[near]
        label = np.where(taught.any(1, keepdims=True), taught, label)
        label = (label / label.sum(1, keepdims=True)).astype(np.float32)
        columns = (lists.x[near], label, lists.prior[near], distance.astype(np.float32))
        return cls(np.concatenate([[0], there.sum(1).cumsum()]), *(column[there] for column in columns))

    def padded(self, rows: NDArray[np.integer]) -> _Tensors:
        """The lists `rows` (b,)."""
        pad = Padding.of(self.start, rows)
        arrays = pad(self.x), pad.there, pad(self.label), pad(self.prior), pad(self.distance)
        return tuple(map(torch.from_numpy, arrays))  # type: ignore[return-value]  # as many as there are arrays

    def some(self, most: int) -> _Tensors:
        """At most `most` of the lists, evenly spread."""
        return self.padded(np.array(evenly(len(self.start) - 1, most), np.int64))


class _Listwise:
    """Soft-label cross-entropy over lists; an `Objective` of the training loop."""

    def __init__(self, learnt: Lists, held_out: Lists, settings: Settings, folder: Path | None) -> None:
        self.learnt = _Taught.of(learnt, settings, folder)
        self.held_out = _Taught.of(held_out, settings, folder).some(HELD_OUT)
        self.size = len(self.learnt.start) - 1

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:  # noqa: ARG002 nothing is random
        return ()

    def loss(self, model: torch.nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:  # noqa: ARG002
        x, there, label, _, _ = self.learnt.padded(rows.numpy())
        return _cross_entropy(model(x, there), label)

    def validation(self, model: torch.nn.Module) -> float:
        x, there, label, _, _ = self.held_out
        return float(_cross_entropy(model(x, there), label)) if len(x) else float("nan")

    @torch.no_grad()
    def goal_distance(self, model: torch.nn.Module) -> float:
        """Distance [m] to where the log ended of the nearest of DRAWN goals: its mean over draws and validation lists."""
        x, there, _, _, distance = self.held_out
        if not len(x):
            return float("nan")
        near, order = distance.sort(-1)
        left = model(x, there).exp().gather(-1, order).flip(-1).cumsum(-1).flip(-1)  # chance that one draw is no nearer
        none = torch.nn.functional.pad(left.clamp(max=1) ** DRAWN, (0, 1))
        return float((near * -none.diff()).sum(-1).mean())


def _staying(odds: NDArray[np.float32], c: Candidates) -> NDArray[np.float32]:
    """The odds (C,) of a parked vehicle, raised for staying to PARKED_STAYS where they are lower."""
    stay = c.manoeuvre == Manoeuvre.STAY
    mass = float(odds[stay].sum())
    if not stay.any() or mass >= PARKED_STAYS:
        return odds
    return np.where(stay, PARKED_STAYS / stay.sum(), odds * (1 - PARKED_STAYS) / (1 - mass)).astype(np.float32)


def _cross_entropy(log_probability: Tensor, label: Tensor) -> Tensor:
    return -(label * log_probability.clamp(min=-30)).sum(-1).mean()


def _floored(score: Tensor, prior: Tensor, temperature: float, floor: float) -> Tensor:
    """Probabilities (B, MOST): tempered scores, and the share `floor` of the candidates' prior."""
    return (1 - floor) * torch.softmax(score / temperature, -1) + floor * prior


@torch.no_grad()
def _temperature(net: Ranker, lists: _Tensors, floor: float) -> float:
    """The temperature of the highest likelihood of the nearest candidate."""
    x, there, label, prior, _ = lists
    if not len(x):
        return 1.0
    score, best = net(x, there), label.argmax(-1, keepdim=True)
    losses = [-_floored(score, prior, float(t), floor).gather(1, best).log().mean().item() for t in TEMPERATURES]
    return float(TEMPERATURES[int(np.argmin(losses))])
