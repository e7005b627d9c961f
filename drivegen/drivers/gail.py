"""GAIL: drives as the logs do (Ho and Ermon 2016); a discriminator tells its steps from theirs, PPO makes that harder.

It begins as a clone of the logs, learns on whole episodes among replayed neighbours, and keeps the running average of its weights
that does best in validation scenes: from one look to the next its collision rate swings by a factor of two and more (`LOG.md`).
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import mse_loss

from drivegen.core.settings import Count, Positive, Share
from drivegen.drivers._gail import discriminator
from drivegen.drivers._gail.discriminator import Discriminator, transitions
from drivegen.drivers.shared import ppo
from drivegen.drivers.shared.episodes import Episodes
from drivegen.drivers.shared.lessons import Grade, Lessons, graded
from drivegen.drivers.shared.network import Network
from drivegen.drivers.shared.policy import Policy
from drivegen.world.world import World


@dataclass(frozen=True)
class Teaching:
    """How it learns.

    Attributes:
        iterations: of PPO. grade_every: iterations between two looks at the validation scenes.
        average: share of the old in the running average of weights.
        clone_steps, clone_rate, clone_batch: Adam's steps, learning rate and batch of the clone.
    """

    iterations: Count
    grade_every: Count
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
        """See `lessons.Taught`."""
        return Teaching

    @classmethod
    def teach(
        cls, how: Teaching, train: Lessons, validation: Lessons, seed: int, say: Callable[[str], None]
    ) -> tuple[Policy, list[Grade]]:
        """See `lessons.Taught`."""
        torch.set_num_threads(1)  # sums depend on the thread count
        torch.manual_seed(seed)
        random = torch.Generator().manual_seed(seed)
        expert, logged = train.demonstrations(), validation.demonstrations()
        policy = _clone(expert, how, random)
        learner, judge = ppo.Learner(policy, how.ppo), Discriminator(transitions(expert), how.discriminator)
        average, kept = copy.deepcopy(policy), copy.deepcopy(policy)
        grades = [graded(0, policy, validation, logged)]
        for iteration in range(1, how.iterations + 1):
            chosen = torch.randint(len(train), (how.ppo.rows,), generator=random)
            episodes = _try(policy, train, chosen, random)
            judge.learn(transitions(episodes), random)
            learner.learn(episodes, judge.reward(episodes, how.ppo.discount), random)
            _pull(average, policy, 1 - how.average)
            if iteration % how.grade_every == 0 or iteration == how.iterations:
                grades.append(graded(iteration, average, validation, logged))
                say(f"iteration {iteration}/{how.iterations}: collisions in {grades[-1].collision:.1%} of validation scenes")
                if grades[-1].badness <= min(grade.badness for grade in grades[1:]):  # the first is the clone's
                    kept = copy.deepcopy(average)
        return kept, grades


def _try(policy: Policy, lessons: Lessons, chosen: Tensor, random: torch.Generator) -> Episodes:
    """Episodes in which the policy does not quite do what it holds for best."""

    def choose(_: int, seen: Tensor, __: World) -> Tensor:
        best: Tensor = policy(seen)
        return best + policy.spread.exp() * torch.randn(len(seen), generator=random)

    return lessons.play(choose, chosen)


@torch.no_grad()
def _pull(average: Policy, policy: Policy, share: float) -> None:
    for old, new in zip(average.parameters(), policy.parameters(), strict=True):
        old.lerp_(new, share)


def _clone(expert: Episodes, how: Teaching, random: torch.Generator) -> Policy:
    policy = Policy()
    optimiser = torch.optim.Adam(policy.parameters(), how.clone_rate)
    seen, number = expert.features[:-1][expert.live], expert.number[expert.live]
    for _ in range(how.clone_steps):
        rows = torch.randint(len(seen), (how.clone_batch,), generator=random)
        loss = mse_loss(policy(seen[rows]), number[rows])
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimiser.step()
    return policy
