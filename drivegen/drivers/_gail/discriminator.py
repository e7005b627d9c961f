"""Who drove: a network that tells the logs' steps from the policy's (Ho and Ermon 2016), and the reward that follows from it.

An episode that a collision or a red light ends early goes on, for the discriminator, in an absorbing state to the end of its
scene (Kostrikov et al. 2019). Otherwise a reward that is never negative would pay far more for lasting, whatever the
discriminator holds of the driving; a little it does, as who drives on is credited with what would come after the scene
(`ppo.advantages`).
"""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn.functional import binary_cross_entropy_with_logits, softplus

from drivegen.core.settings import Count, NotNegative, Positive
from drivegen.drivers.shared.episodes import Episodes
from drivegen.drivers.shared.features import COUNT

_CLIP = 5.0


@dataclass(frozen=True)
class Settings:
    """Of the discriminator.

    Attributes:
        hidden: width of its two layers. steps: of its optimiser in an iteration. batch: steps of either side in each.
        learning_rate: Adam's. penalty: of its gradient between both sides. noise: deviation added to what was done: standing logs
            have exact zeros, by which alone they could be told.
    """

    hidden: Count
    steps: Count
    batch: Count
    learning_rate: Positive
    penalty: NotNegative
    noise: NotNegative


def transitions(episodes: Episodes) -> Tensor:
    """(D, COUNT + 2) what was seen and done at live steps, and the absorbing steps of episodes that ended at a fault."""
    steps = torch.cat([episodes.features[:-1], episodes.number[..., None], torch.zeros_like(episodes.number)[..., None]], dim=-1)
    absorbed = torch.zeros(int(_absorbed(episodes).sum()), COUNT + 2)
    absorbed[:, -1] = 1.0
    return torch.cat([steps[episodes.live], absorbed])


def _absorbed(episodes: Episodes) -> Tensor:
    """(R,) steps that each episode spends in the absorbing state."""
    return torch.where(episodes.failed, episodes.lasts - episodes.live.sum(0), 0)


class Discriminator(nn.Module):
    """Steps (D, COUNT + 2) -> logit (D,) that a log drove them."""

    def __init__(self, expert: Tensor, settings: Settings) -> None:
        super().__init__()
        self.settings = settings
        mean, scale = expert.mean(0), expert.std(0).clamp_min(0.05)
        mean[-1], scale[-1] = 0.0, 1.0  # hardly anybody is absorbed in a log
        self._expert, self._mean, self._scale = expert, nn.Buffer(mean), nn.Buffer(scale)
        hidden = settings.hidden
        self.layers = nn.Sequential(
            nn.Linear(COUNT + 2, hidden), nn.Tanh(), nn.Linear(hidden, hidden), nn.Tanh(), nn.Linear(hidden, 1)
        )
        self.optimiser = torch.optim.Adam(self.layers.parameters(), settings.learning_rate)

    def forward(self, steps: Tensor) -> Tensor:
        """See the class."""
        logit: Tensor = self.layers(((steps - self._mean) / self._scale).clamp(-_CLIP, _CLIP))[:, 0]
        return logit

    def learn(self, policy: Tensor, random: torch.Generator) -> float:
        """One iteration against the policy's steps; the share of both sides that it told rightly."""
        right = 0.0
        for _ in range(self.settings.steps):
            expert, other = (self._batch(steps, random) for steps in (self._expert, policy))
            logits = self(expert), self(other)
            loss = sum(
                binary_cross_entropy_with_logits(logit, torch.full_like(logit, float(truth)))
                for logit, truth in zip(logits, (1, 0), strict=True)
            )
            loss = loss + self.settings.penalty * self._steepness(expert, other, random)
            self.optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self.optimiser.step()
            right += float(((logits[0] > 0).float().mean() + (logits[1] <= 0).float().mean()) / 2)
        return right / self.settings.steps

    def _batch(self, steps: Tensor, random: torch.Generator) -> Tensor:
        batch = steps[torch.randint(len(steps), (self.settings.batch,), generator=random)]
        noise = self.settings.noise * torch.randn(len(batch), generator=random) * (1 - batch[:, -1])
        return torch.cat([batch[:, :COUNT], (batch[:, COUNT] + noise)[:, None], batch[:, COUNT + 1 :]], dim=1)

    def _steepness(self, a: Tensor, b: Tensor, random: torch.Generator) -> Tensor:
        """Mean of (|gradient| - 1)^2 between both sides (Gulrajani et al. 2017), in standardised inputs."""
        share = torch.rand(len(a), 1, generator=random)
        between = (share * a + (1 - share) * b - self._mean) / self._scale
        between = between.clamp(-_CLIP, _CLIP).requires_grad_()
        (slope,) = torch.autograd.grad(self.layers(between).sum(), between, create_graph=True)
        steepness: Tensor = (slope.norm(dim=1) - 1).square().mean()
        return steepness

    @torch.no_grad()
    def reward(self, episodes: Episodes, discount: float) -> Tensor:
        """(T, R): 0.1 log(1 + exp(logit)), at an episode's last step before a fault with all that the absorbing ones pay."""
        flat = torch.cat(
            [episodes.features[:-1], episodes.number[..., None], torch.zeros_like(episodes.number)[..., None]], dim=-1
        )
        reward = 0.1 * softplus(self(flat.flatten(0, 1))).view(episodes.number.shape)
        absorbed = torch.zeros(1, COUNT + 2)
        absorbed[0, -1] = 1.0
        each = 0.1 * float(softplus(self(absorbed)))
        paid = discount * each * (1 - discount ** _absorbed(episodes)) / (1 - discount)
        last = episodes.live.sum(0).sub(1).clamp_min(0)
        reward[last, torch.arange(len(last))] += torch.where(episodes.failed, paid, 0.0)
        return reward
