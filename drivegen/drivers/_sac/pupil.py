"""Stable-Baselines3's SAC, round by round, so that what a round depends on can be kept and taken up again."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.buffers import ReplayBuffer
from torch import nn

from drivegen.drivers.shared.environment import Environment
from drivegen.drivers.shared.lessons import Lessons
from drivegen.drivers.shared.policy import WIDTHS, Policy
from drivegen.drivers.shared.vec_env import WorldVecEnv
from drivegen.training.checkpoint import Part

if TYPE_CHECKING:
    from drivegen.drivers.sac import Teaching

SEEDS = 2**32
"""NumPy's global generator, from which the replay buffer draws, takes no larger seed."""


class Learner:
    """The policy with its critics and everything that it has been through; see `teaching.Pupil`."""

    def __init__(self, how: "Teaching", lessons: Lessons, seed: int) -> None:
        self._how, self._env = how, WorldVecEnv(Environment(lessons.traffic, how.rows, how.environment))
        self._sac = SAC(
            "MlpPolicy",
            self._env,
            learning_rate=how.learning_rate,
            buffer_size=how.course.rounds * how.steps * how.rows,
            learning_starts=0,
            batch_size=how.batch,
            tau=how.pull,
            gamma=how.discount,
            n_steps=how.rewards,
            train_freq=1,
            gradient_steps=how.updates,
            ent_coef=f"auto_{how.entropy}",
            policy_kwargs={"net_arch": list(WIDTHS[:-1]), "optimizer_kwargs": {"fused": True}},
            seed=seed % SEEDS,
            device="cpu",
        )
        actor = self._sac.actor
        self.policy = self.tries = Policy(nn.Sequential(*actor.latent_pi, actor.mu), squashed=True)

    @property
    def parts(self) -> Mapping[str, Part]:
        """See `teaching.Pupil`."""
        sac, entropy = self._sac, self._sac.ent_coef_optimizer
        assert sac.log_ent_coef is not None
        assert entropy is not None
        adams = {"actor_adam": sac.actor.optimizer, "critic_adam": sac.critic.optimizer, "entropy_adam": entropy}
        names = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
        lived = {name: torch.from_numpy(getattr(self._buffer, name)) for name in names}
        return {"networks": sac.policy, "entropy": sac.log_ent_coef, **adams, **lived}

    def begin(self, seed: int) -> None:
        """Nothing comes before the first round."""

    def study(self, number: int, seed: int) -> None:
        """Drive and learn by turns; all rows begin new episodes, so that no state of the world need be kept."""
        how, before = self._how, number - 1
        self._sac.num_timesteps, self._buffer.pos = before * how.steps * how.rows, before * how.steps
        self._sac.set_random_seed(seed % SEEDS)
        self._sac.set_env(self._env, force_reset=True)
        self._sac.learn(how.steps * how.rows, reset_num_timesteps=False)
        last, lived = self._buffer.pos - 1, self._buffer
        lived.timeouts[last] = np.maximum(
            lived.timeouts[last], 1 - lived.dones[last]
        )  # cut short, but for those that ended there

    @property
    def _buffer(self) -> ReplayBuffer:
        assert self._sac.replay_buffer is not None
        return self._sac.replay_buffer
