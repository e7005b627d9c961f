"""The default selector: a small listwise ranker that imitates logs. It is not a language model and does not pretend to be.

Trained on the train split's logs: cross-entropy between the softmax over a vehicle's candidates and the soft label
exp(-d^2 / 2 sigma^2), d the distance from the logged end, sigma wider for vehicles that left the scene before. The weights
of the lowest validation loss are kept; then one temperature is set on the validation split so that
its probabilities mean what they say. A share `floor` of them is spread evenly: on roads and drivers unlike those learnt from
no ranker should be surer than that. It may also be taught by another selector's recorded odds; its description then says whose.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file
from torch import Tensor

from drivegen import seeds
from drivegen.errors import MissingTool, UnusableInput
from drivegen.goals.candidates import Candidates
from drivegen.lanes.graph import LaneGraph
from drivegen.scenario import Scenario
from drivegen.selectors._features import NAMES, features
from drivegen.selectors._labels import ends
from drivegen.selectors._ranker import MOST, Ranker
from drivegen.selectors.base import FirstFrameSelector
from drivegen.store.files import whole, write_json
from drivegen.training.curve import LossRow
from drivegen.training.loop import Settings as Training
from drivegen.training.loop import train

WEIGHTS, ABOUT = "ranker.safetensors", "ranker.json"

CHUNK = 64
"""Lists are ranked in chunks of this many, padded, so that a result does not depend on its neighbours."""

TEMPERATURES = np.exp(np.linspace(-1.0, 1.5, 51))
"""Tried on the validation split."""


@dataclass(frozen=True)
class Settings:
    """How to learn.

    Attributes:
        width: of the layers. dropout: share of their outputs. sigma: [m] width of the soft label. farthest: [m] lists
            whose nearest candidate is farther from the logged end are left out; a doubtful end may be farther away.
        floor: share of the probability that is spread evenly over the candidates. training: the loop's settings.
    """

    width: int
    dropout: float
    sigma: float
    farthest: float
    floor: float
    training: Training

    def __post_init__(self) -> None:
        if not 0 <= self.floor < 1:
            raise UnusableInput(f"train_selector.learned: floor is a share below 1, not {self.floor:g}")


@dataclass(frozen=True)
class Lists:
    """V lists to learn from, padded.

    Attributes:
        x: (V, MOST, F) features. distance: (V, MOST) [m] of candidates from the logged end, inf for none.
        doubt: (V,) [m] standard deviation of that end, 0 where it was seen.
        taught: (V, MOST) a teacher's odds, which are the label then; all zero where the log is.
    """

    x: NDArray[np.float32]
    distance: NDArray[np.float32]
    doubt: NDArray[np.float32]
    taught: NDArray[np.float32]

    @classmethod
    def none(cls) -> "Lists":
        """No list."""
        rows = np.zeros((0, MOST), np.float32)
        return cls(np.zeros((0, MOST, len(NAMES)), np.float32), rows, rows[:, 0], rows)

    @classmethod
    def of(cls, scenario: Scenario, candidates: Sequence[Candidates]) -> "Lists":
        """Those of all vehicles whose logged end can be a label."""
        labels = ends(scenario, candidates)
        if len(labels.vehicle) == 0:
            return cls.none()
        given = features(scenario, candidates)
        x, there = _padded([given[n] for n in labels.vehicle.tolist()])
        distance = np.full(there.shape, np.inf, np.float32)
        for i, n in enumerate(labels.vehicle.tolist()):
            distance[i, : len(candidates[n])] = np.hypot(*(candidates[n].position - labels.position[i]).T)
        return cls(x, distance, labels.doubt.astype(np.float32), np.zeros_like(distance))

    @classmethod
    def by_teacher(cls, scenario: Scenario, candidates: Sequence[Candidates], odds: Sequence[NDArray[np.float32]]) -> "Lists":
        """Those of all vehicles, labelled with a teacher's `odds` (C,); whether there is a log does not matter."""
        x, there = _padded(features(scenario, candidates))
        taught = np.zeros(there.shape, np.float32)
        for row, p in zip(taught, odds, strict=True):
            row[: len(p)] = p
        return cls(x, np.where(there, 0.0, np.inf).astype(np.float32), np.zeros(len(x), np.float32), taught)

    @classmethod
    def joined(cls, parts: "Sequence[Lists]") -> "Lists":
        """All of them, in order."""
        return cls(*(np.concatenate([getattr(p, name) for p in parts]) for name in cls.__dataclass_fields__))

    def __len__(self) -> int:
        return len(self.x)


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
        objective = _Listwise(learnt, held_out, settings)
        if objective.size:
            rows = objective.x[objective.there]
            net.mean.copy_(rows.mean(0))
            net.scale.copy_(rows.std(0).clamp(min=0.05))
        net, curve = train(net, objective, settings.training, seed, checkpoint, report, keep_best=True)
        calibration = objective if len(held_out) == 0 else _Listwise(held_out, held_out, settings)
        net.temperature.fill_(_temperature(net.eval(), calibration, settings.floor))
        return cls(net, settings.floor, described=f"learned selector (distilled from {teacher})" if teacher else ""), curve

    def rank(
        self,
        graph: LaneGraph,  # noqa: ARG002 protocol
        scenario: Scenario,
        candidates: Sequence[Candidates],
    ) -> list[NDArray[np.float32]]:
        """Calibrated probabilities."""
        x, there = _padded(features(scenario, candidates))
        x = np.ascontiguousarray(x[..., self._columns])
        chunks = [self._chunk(x[i : i + CHUNK], there[i : i + CHUNK]) for i in range(0, len(x), CHUNK)]
        return [p[: len(c)] for p, c in zip(np.concatenate(chunks), candidates, strict=True)]

    def _chunk(self, x: NDArray[np.float32], there: NDArray[np.bool_]) -> NDArray[np.float32]:
        """Probabilities (b, MOST) of one chunk of at most CHUNK lists, computed at full size."""
        padding = CHUNK - len(x)
        whole_x = torch.from_numpy(np.pad(x, ((0, padding), (0, 0), (0, 0))))
        whole_there = torch.from_numpy(np.pad(there, ((0, padding), (0, 0))))
        p = _floored(self.net(whole_x, whole_there), whole_there, float(self.net.temperature), self.floor)
        return p[: len(x)].numpy()

    def save(self, folder: Path) -> None:
        """Weights as safetensors, and what they belong to; equal weights give equal bytes."""
        with whole(folder / WEIGHTS) as temporary:
            save_file(self.net.state_dict(), temporary)
        known = [NAMES[column] for column in self._columns]
        about = {"described": self.described, "features": known, "width": self.net.each[0].out_features, "floor": self.floor}
        write_json(folder / ABOUT, about)

    @classmethod
    def load(cls, folder: Path) -> Self:
        """What `save` wrote. Raises MissingTool where there are no weights, UnusableInput where they are not ours."""
        if not (folder / WEIGHTS).exists() or not (folder / ABOUT).exists():
            raise MissingTool(f"{folder} holds no trained goal selector: run the train_selector stage (`make run`)")
        try:
            about = json.loads((folder / ABOUT).read_text())
            known = tuple(about["features"])
            if not set(known) <= set(NAMES):
                raise UnusableInput(f"{folder} was trained on other features: run the train_selector stage again")
            net = Ranker(len(known), int(about["width"]))
            net.load_state_dict(load_file(folder / WEIGHTS))
            return cls(net, float(about.get("floor", 0.0)), known, str(about["described"]))
        except (ValueError, KeyError, TypeError, RuntimeError, SafetensorError) as error:
            what = str(error).splitlines()[0]
            raise UnusableInput(f"{folder} holds damaged weights of a goal selector ({what}): train it again") from None


class _Listwise:
    """Soft-label cross-entropy over lists; an `Objective` of the training loop."""

    def __init__(self, learnt: Lists, held_out: Lists, settings: Settings) -> None:
        self.x, self.there, self.label = _tensors(learnt, settings)
        self.held_out = _tensors(held_out, settings)
        self.size = len(self.x)

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:  # noqa: ARG002 nothing is random
        return ()

    def loss(self, model: torch.nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:  # noqa: ARG002
        return _cross_entropy(model(self.x[rows], self.there[rows]), self.label[rows])

    def validation(self, model: torch.nn.Module) -> float:
        x, there, label = self.held_out
        return float(_cross_entropy(model(x, there), label)) if len(x) else float("nan")


def _cross_entropy(log_probability: Tensor, label: Tensor) -> Tensor:
    return -(label * log_probability.clamp(min=-30)).sum(-1).mean()


def _tensors(lists: Lists, settings: Settings) -> tuple[Tensor, Tensor, Tensor]:
    """x, there, soft label of the lists that have a candidate near enough."""
    near = lists.distance.min(1, initial=np.inf) <= settings.farthest + lists.doubt
    distance, doubt = lists.distance[near].astype(np.float64), lists.doubt[near, None].astype(np.float64)
    label = np.exp(-(distance**2 - distance.min(1, keepdims=True) ** 2) / (2 * (settings.sigma**2 + doubt**2)))
    taught = lists.taught[near]
    label = np.where(taught.any(1, keepdims=True), taught, label)
    label = (label / label.sum(1, keepdims=True)).astype(np.float32)
    return torch.from_numpy(lists.x[near]), torch.from_numpy(np.isfinite(distance)), torch.from_numpy(label)


def _floored(score: Tensor, there: Tensor, temperature: float, floor: float) -> Tensor:
    """Probabilities (B, MOST): tempered scores, and the share `floor` spread evenly over the candidates that are `there`."""
    evenly = there / there.sum(-1, keepdim=True).clamp(min=1)
    return (1 - floor) * torch.softmax(score / temperature, -1) + floor * evenly


@torch.no_grad()
def _temperature(net: Ranker, lists: _Listwise, floor: float) -> float:
    """The temperature of the highest likelihood of the nearest candidate."""
    if lists.size == 0:
        return 1.0
    score, best = net(lists.x, lists.there), lists.label.argmax(-1, keepdim=True)
    losses = [-_floored(score, lists.there, float(t), floor).gather(1, best).log().mean().item() for t in TEMPERATURES]
    return float(TEMPERATURES[int(np.argmin(losses))])


def _padded(lists: Sequence[NDArray[np.float32]]) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """x (V, MOST, F), there (V, MOST). Raises UnusableInput where a list is longer than MOST."""
    x = np.zeros((len(lists), MOST, len(NAMES)), np.float32)
    there = np.zeros((len(lists), MOST), np.bool_)
    for i, rows in enumerate(lists):
        if len(rows) > MOST:
            raise UnusableInput(f"a vehicle has {len(rows)} candidates, the learned selector ranks {MOST} at most")
        x[i, : len(rows)], there[i, : len(rows)] = rows, True
    return x, there
