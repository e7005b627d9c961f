"""SceneTransformer (Ngiam et al., ICLR 2022): one network for the joint future of all agents, F futures at once.

As in the paper: a token for every agent and time, attention factorised into layers over time and layers over agents,
cross-attention to the road, hidden (masked) tokens for the future, one learnt embedding for each of F futures, decoded
together; the loss is the joint best of F (the future whose mean displacement over all agents is least) plus the
classification of which one that is. The task is their behaviour prediction with a history of one step.

Reduced, by settings: width and layers (theirs are 256 wide and some twenty deep); a token spans seconds, not 0.1 s;
displacement by its length, not by a Laplace distribution with learnt scales; a smooth curve of few degrees of freedom
in each direction; no conditional or goal-directed tasks.
Changed, to its advantage where scenes are few: roads and neighbours are seen in each agent's own frame and relations
between agents are a bias of attention, where the paper has one frame for the scene. Of the road, each agent sees the
nearest pieces. A small share of the loss is the mean of all F futures, so that those that are never the best learn, too.

K futures are drawn without repetition from the F by their probabilities, which thus choose nothing where K is F; where K exceeds
F, all of them, again and again.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count, Share, Within, expect_multiple
from drivegen.generators._scene_transformer.net import SceneTransformerNet
from drivegen.generators.shared.learned import Learned
from drivegen.generators.shared.motion import KNOTS, filled_in, trajectories
from drivegen.generators.shared.objective import Objective
from drivegen.generators.shared.vectors import PIECES, Scenes, displacement
from drivegen.training import loop

ABOUT = Method(
    title="SceneTransformer",
    line="One network for the joint future of all vehicles, several futures at once (Ngiam et al., ICLR 2022).",
    kind="learned",
    goals=None,
    trains_on="the logs",
    places=False,
    additions=(),
)

CHUNK = 8
"""Scenes that go through the network at once, always: sums differ between batch sizes."""


@dataclass(frozen=True)
class SceneTransformerSettings:
    """Values stand in params.yaml, `train_generator.generators.scene_transformer`.

    Attributes:
        width, heads: of the transformer; `width` is a multiple of `heads`.
        layers: rounds of road, time and agents before the futures part. decoder_layers: of time and agents for each future.
        modes: F. stretches: tokens of the future, a divisor of KNOTS. pieces: of road that each agent sees.
        relaxed: weight of the mean of all futures, the rest being that of the best. training: see `training.loop.Settings`.
    """

    width: Count
    heads: Count
    layers: Count
    decoder_layers: Count
    modes: Count
    stretches: Count
    pieces: Annotated[int, Within(1, PIECES)]
    relaxed: Share
    training: loop.Settings

    def __post_init__(self) -> None:
        place = "train_generator.generators.scene_transformer"
        expect_multiple(f"{place}.width", self.width, self.heads, "heads")
        if KNOTS % self.stretches:
            raise UnusableInput(f"{place}.stretches must be a divisor of {KNOTS}, not {self.stretches}")


class Plugin(Learned):
    """See the module."""

    name = "scene_transformer"
    about = ABOUT
    Settings = SceneTransformerSettings
    Examples = Scenes

    @classmethod
    def network(cls, settings: SceneTransformerSettings) -> nn.Module:
        """See `Learned`."""
        s = settings
        return SceneTransformerNet(s.width, s.heads, s.layers, s.decoder_layers, s.modes, s.stretches, s.pieces)

    @classmethod
    def examples(cls, settings: SceneTransformerSettings, scenarios: Sequence[Scenario]) -> Scenes:
        """See `Learned`."""
        del settings
        return Scenes.with_logs(scenarios)

    @classmethod
    def objective(
        cls, settings: SceneTransformerSettings, net: nn.Module, train: Scenes, validation: Scenes, seed: int
    ) -> loop.Objective:
        """See `Learned`."""
        del net, seed
        return _BestOfF(train, validation, settings.relaxed)

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K joint futures of each scenario."""
        made: list[Samples] = []
        for low in range(0, len(scenarios), CHUNK):
            chunk = scenarios[low : low + CHUNK]
            scenes = Scenes.of(chunk).padded(CHUNK)
            with torch.inference_mode():
                knots, logits = (x.numpy() for x in self.net(scenes.tensors(torch.device("cpu"))))
            for row, scenario in enumerate(chunk):
                picked = _picked(logits[row], samples, seeds.rng(seed, self.name, scenario.scenario_id))
                count = len(scenario.vehicles)
                dense = filled_in(knots[row], scenes.speed[row])
                motion = trajectories(scenario, *(x[picked][:, :count] for x in dense))
                made.append(Samples.without_goals(scenario.scenario_id, self.name, motion))
        return made


def _picked(logits: NDArray[np.float32], count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Numbers (count,) of futures: draws without repetition (Gumbel's trick), begun again when all have been drawn."""
    order = np.argsort(-(logits + rng.gumbel(size=len(logits))), kind="stable")
    return np.resize(order, count)


class _BestOfF(Objective):
    """Displacement of the joint future that is nearest to the log, and the cross-entropy of choosing it."""

    chunk = 32

    def __init__(self, train: Scenes, held_out: Scenes, relaxed: float) -> None:
        super().__init__(train, held_out)
        self.relaxed = relaxed

    def mean(self, model: nn.Module, examples: Scenes, rows: NDArray[np.integer], device: torch.device, *_: Tensor) -> Tensor:
        scenes = examples[rows].tensors(device)
        knots, logits = model(scenes)
        each, agents = displacement(scenes, knots, futures=1)
        joint = (each * agents).sum(-1) / agents.sum(-1).clamp_min(1)  # (S, F)
        best, which = joint.min(dim=1)
        error = (1 - self.relaxed) * best + self.relaxed * joint.mean(dim=1)
        loss: Tensor = (error + nn.functional.cross_entropy(logits, which, reduction="none")).mean()
        return loss
