"""Proximal policy optimisation (Schulman et al. 2017) on whole episodes: advantages, and the clipped update."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import torch
from torch import Tensor
from torch.nn.utils import clip_grad_norm_

from drivegen.core.settings import Count, Positive, Share, Within
from drivegen.drivers.shared.episodes import Episodes
from drivegen.drivers.shared.policy import Gaussian, Value


@dataclass(frozen=True)
class Settings:
    """Of the update.

    Attributes:
        rows: episodes of an iteration. epochs: times that each is learnt from. batch: steps of one optimiser step.
        learning_rate: Adam's. clip: of the ratio of likelihoods. discount, below 1, and smoothing: gamma and lambda of
            GAE.
    """

    rows: Count
    epochs: Count
    batch: Count
    learning_rate: Positive
    clip: Positive
    discount: Annotated[float, Within(0, 0.9999)]
    smoothing: Share


def advantages(reward: Tensor, value: Tensor, episodes: Episodes, settings: Settings) -> Tensor:
    """(T, R) by generalised advantage estimation (Schulman et al. 2016); `value` is (T + 1, R).

    An episode that ends with its scene is cut off, not over: what would come is its last value. After a fault nothing comes.
    """
    live = episodes.live
    following = torch.cat([live[1:], torch.zeros_like(live[:1])])
    last = live & ~following
    after = torch.where(last & episodes.failed, 0.0, value[1:])
    wrong = reward + settings.discount * after - value[:-1]
    out, gained = torch.zeros_like(reward), torch.zeros_like(reward[0])
    for t in range(len(reward) - 1, -1, -1):
        later = torch.where(following[t], gained, 0.0)
        gained = torch.where(live[t], wrong[t] + settings.discount * settings.smoothing * later, 0.0)
        out[t] = gained
    return out


class Learner:
    """A policy and its value with one optimiser."""

    def __init__(self, policy: Gaussian, settings: Settings) -> None:
        self.policy, self.value, self.settings = policy, Value(), settings
        self.optimiser = torch.optim.Adam([*policy.parameters(), *self.value.parameters()], settings.learning_rate)

    def learn(self, episodes: Episodes, reward: Tensor, random: torch.Generator) -> None:
        """One iteration: `reward` (T, R) counts at live steps."""
        with torch.no_grad():
            value = self.value(episodes.features.flatten(0, 1)).view(episodes.features.shape[:2])
            gain = advantages(reward, value, episodes, self.settings)[episodes.live]
            features, number = episodes.features[:-1][episodes.live], episodes.number[episodes.live]
            goal = gain + value[:-1][episodes.live]
            before = self.policy.likelihood(features, number)
            gain = (gain - gain.mean()) / (gain.std() + 1e-6)
        for rows in self._batches(len(features), random):
            ratio = (self.policy.likelihood(features[rows], number[rows]) - before[rows]).exp()
            near = ratio.clamp(1 - self.settings.clip, 1 + self.settings.clip)
            surrogate = torch.minimum(ratio * gain[rows], near * gain[rows]).mean()
            loss = 0.5 * (self.value(features[rows]) - goal[rows]).square().mean() - surrogate
            self.optimiser.zero_grad()
            loss.backward()
            clip_grad_norm_([*self.policy.parameters(), *self.value.parameters()], 1.0)
            self.optimiser.step()

    def _batches(self, count: int, random: torch.Generator) -> Iterator[Tensor]:
        for _ in range(self.settings.epochs):
            order = torch.randperm(count, generator=random)
            yield from (order[low : low + self.settings.batch] for low in range(0, count, self.settings.batch))
