"""GAIL: drives as the logs do (Ho and Ermon 2016); a discriminator tells its steps from theirs, PPO makes that harder.

It begins as a clone of the logs, learns on whole episodes, and keeps the running average of its weights that does best in
validation scenes: from one look to the next its collision rate swings by a factor of two and more (`LOG.md`).
"""

import copy
from collections.abc import Mapping
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import mse_loss

from drivegen.core.settings import Count, Positive, Share
from drivegen.drivers._gail import discriminator
from drivegen.drivers._gail.discriminator import Discriminator, transitions
from drivegen.drivers.shared import ppo
from drivegen.drivers.shared.episodes import play
from drivegen.drivers.shared.lessons import Lessons
from drivegen.drivers.shared.network import Network
from drivegen.drivers.shared.policy import Gaussian
from drivegen.drivers.shared.teaching import Course
from drivegen.training.checkpoint import Part
from drivegen.world.reactive import Reaction
from drivegen.world.world import World


@dataclass(frozen=True)
class Teaching:
    """How it learns.

    Attributes:
        reaction: of its neighbours while it learns, None for replayed ones.
        average: share of the old in the running average, a round.
        clone_steps, clone_rate, clone_batch: Adam's steps, learning rate and batch of the clone.
    """

    course: Course
    reaction: Reaction | None
    average: Share
    clone_steps: Count
    clone_rate: Positive
    clone_batch: Count
    ppo: ppo.Settings
    discriminator: discriminator.Settings


class Plugin(Network):
    """The policy as a driver."""

    name = "gail"

    @classmethod
    def lessons_type(cls) -> type:
        """See `teaching.Taught`."""
        return Teaching

    @classmethod
    def pupil(cls, how: Teaching, lessons: Lessons, seed: int) -> "Pupil":
        """See `teaching.Taught`."""
        return Pupil(how, lessons, seed)


class Pupil:
    """The policy with its value and its judge; see `teaching.Pupil`."""

    def __init__(self, how: Teaching, lessons: Lessons, seed: int) -> None:
        torch.manual_seed(seed)
        self._how, self._lessons, self._expert = how, lessons, lessons.demonstrations()
        self._world = lessons.world(how.ppo.rows, how.reaction)
        self.tries = Gaussian()
        self._learner = ppo.Learner(self.tries, how.ppo)
        self._judge = Discriminator(transitions(self._expert), how.discriminator)
        self.policy = copy.deepcopy(self.tries)

    @property
    def parts(self) -> Mapping[str, Part]:
        """See `teaching.Pupil`."""
        learner, judge = self._learner, self._judge
        optimisers = {"adam": learner.optimiser, "judge_adam": judge.optimiser}
        return {"tries": self.tries, "value": learner.value, "judge": judge, "policy": self.policy, **optimisers}

    def begin(self, seed: int) -> None:
        """Clone the logs."""
        how, random = self._how, torch.Generator().manual_seed(seed)
        optimiser = torch.optim.Adam(self.tries.parameters(), how.clone_rate)
        features, number = self._expert.features[:-1][self._expert.live], self._expert.number[self._expert.live]
        for _ in range(how.clone_steps):
            rows = torch.randint(len(features), (how.clone_batch,), generator=random)
            loss = mse_loss(self.tries(features[rows]), number[rows])
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        self.policy.load_state_dict(self.tries.state_dict())

    def study(self, number: int, seed: int) -> None:  # noqa: ARG002 as every pupil's
        """Episodes in which the policy does not quite do what it holds for best; judge and policy learn from them."""
        random, tries, how = torch.Generator().manual_seed(seed), self.tries, self._how

        def choose(_: int, features: Tensor, __: World) -> Tensor:
            best: Tensor = tries(features)
            return best + tries.spread.exp() * torch.randn(len(features), generator=random)

        episodes = play(self._world, torch.randint(len(self._lessons), (how.ppo.rows,), generator=random), choose)
        self._judge.learn(transitions(episodes), random)
        self._learner.learn(episodes, self._judge.reward(episodes, how.ppo.discount), random)
        with torch.no_grad():
            for old, new in zip(self.policy.parameters(), tries.parameters(), strict=True):
                old.lerp_(new, 1 - how.average)
