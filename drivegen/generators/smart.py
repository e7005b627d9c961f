"""SMART (Wu et al., NeurIPS 2024): motion as words of half a second, the next of which is predicted as a language model does.

What is the paper's: a vocabulary of motions clustered from logs (k-disks, boxes' corners compared), the map as tokens, too;
attention factorised over a vehicle's own past, the map and the others, all told in relative positions; the cross-entropy of
the next token; noise in matching, so that what is learnt leads back from slips; in closed loop a token for every vehicle is
drawn, driven and seen again.

What is reduced: width, layers and the vocabulary, one for all kinds (paper: 2 048 tokens); pieces of lanes stand for the map's
tokens, are looked at by vehicles only and are not taught to continue themselves; a window of the last tokens is remembered; no
history, since only the first frame is given. What is added: some scenes are cut, so that any moment may be a first frame,
whose signals are told until the end; odds of a token are a product with a code of its motion, so that motions alike share what is
learnt, and fall with its distance from the motion that is expected, which is the last one before anything is learnt.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import Count, Share
from drivegen.generators._smart.around import PIECE
from drivegen.generators._smart.driving import Driver
from drivegen.generators._smart.learning import HELD_OUT, Examples, Slips, SmartObjective
from drivegen.generators._smart.net import SmartNet
from drivegen.generators._smart.tokens import Vocabulary, codes, disks, motions
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.generators.shared.lanes import Logs
from drivegen.generators.shared.learned import Learned
from drivegen.training import loop

ABOUT = Method(
    title="SMART",
    line="Motion as words of half a second; the next is drawn for each vehicle, and seen by all (Wu et al., NeurIPS 2024).",
    kind="learned",
    goals=None,
    trains_on="the logs",
    places=False,
    additions=(),
)


@dataclass(frozen=True)
class SmartSettings:
    """Values stand in params.yaml, `train_generator.generators.smart`.

    Attributes:
        tokens: of the vocabulary. lanes, boxes: pieces of lanes and boxes (itself among them) that a vehicle sees, the nearest.
        width, heads, layers: of the network. memory: last tokens that a vehicle knows of itself.
        slips: how logs are told in training.
        likely: how tokens are drawn, see `_smart.driving.Driver`.
        training: see `training.loop.Settings`; a batch is so many scenes.
    """

    tokens: Count
    lanes: Count
    boxes: Count
    width: Count
    heads: Count
    layers: Count
    memory: Count
    slips: Slips
    likely: Share
    training: loop.Settings


class Plugin(Learned):
    """See `generators.shared.learned.Learned`."""

    name = "smart"
    tempered = True
    about = ABOUT
    Settings = SmartSettings
    Examples = Logs
    settings: SmartSettings
    net: SmartNet

    @classmethod
    def network(cls, settings: SmartSettings) -> SmartNet:
        """See `Learned`."""
        return SmartNet(settings.tokens, settings.width, settings.heads, settings.layers, settings.memory)

    @classmethod
    def examples(cls, settings: SmartSettings, scenarios: Sequence[Scenario]) -> Logs:
        """See `Learned`."""
        del settings
        return Logs.of(scenarios, PIECE)

    @classmethod
    def objective(cls, settings: SmartSettings, net: SmartNet, train: Logs, validation: Logs, seed: int) -> SmartObjective:
        """See `Learned`; the vocabulary becomes a part of the network."""
        way = disks(motions(train.tracks), settings.tokens, seeds.rng(seed, cls.name, "vocabulary"))
        net.way.copy_(torch.from_numpy(way))
        net.code.copy_(torch.from_numpy(codes(way)))
        counts, words = (settings.lanes, settings.boxes), Vocabulary(way)
        return SmartObjective(Examples(train, words, counts), Examples(validation, words, counts, HELD_OUT), settings.slips)

    def log_likelihood(self, scenarios: Sequence[Scenario], traffic: Sequence[Trajectories]) -> list[NDArray[np.float64]]:
        """(N,) [nat per token] mean log odds of the tokens that each vehicle's motion in `traffic` (N, T) is told in.

        What others do is known as it happens. A motion is told in the nearest tokens; how far it is from these does not count.
        """
        counts, words, means = (self.settings.lanes, self.settings.boxes), Vocabulary(self.net.way.numpy()), []
        for scenario, motion in zip(scenarios, traffic, strict=True):
            logs = self.examples(self.settings, [replace(scenario, log=motion)])
            seen, target = Examples(logs, words, counts).plain(np.zeros(1, np.int64))
            with torch.inference_mode():
                odds = self.net(seen)[0].log_softmax(-1).gather(-1, target.clamp_min(0)[..., None])[..., 0]
            scored = (target >= 0).numpy()
            total = np.where(scored, odds.numpy().astype(np.float64), 0.0).sum(1)
            means.append(np.where(scored.any(1), total / np.maximum(scored.sum(1), 1), np.nan))
        return means

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` futures of each scenario, driven in closed loop, all of a scenario at once."""
        counts = self.settings.lanes, self.settings.boxes
        driver = Driver(self.net, counts, float(self.temperature), self.settings.likely)
        made = []
        with torch.inference_mode():
            for scenario in scenarios:
                tracks = Tracks.of_beginnings([scenario], samples)
                driver.drive(scenario, tracks, seeds.rng(seed, self.name, scenario.scenario_id))
                made += tracks.samples([scenario], samples, self.name)
        return made
