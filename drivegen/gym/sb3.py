"""Stable-Baselines3's `VecEnv` over the batched world, and its policies as files of weights."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv
from torch import nn

from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.network import write_network
from drivegen.gym.folders import Traffic
from drivegen.gym.settings import Settings
from drivegen.gym.vector import DriveVectorEnv

Indices = int | Iterable[int] | None


def save_policy(model: BaseAlgorithm, folder: str | Path, name: str) -> None:
    """Write the network of a SAC's or PPO's policy as the weights of the driver `name` (`drivers.shared.network`).

    Raises UnusableInput for other algorithms, and for networks that are more than linear layers with one kind of activation.
    """
    policy: Any = model.policy
    sac = isinstance(model, SAC)
    if not sac and not isinstance(model, PPO):
        raise UnusableInput(f"{type(model).__name__} is neither SAC nor PPO: its policy is no network of ours")
    parts = [*policy.actor.latent_pi, policy.actor.mu] if sac else [*policy.mlp_extractor.policy_net, policy.action_net]
    linear = [part for part in parts if isinstance(part, nn.Linear)]
    activation = policy.activation_fn.__name__.lower()
    if len(parts) != 2 * len(linear) - 1:
        raise UnusableInput("the policy has layers that are neither linear nor activations between them")
    write_network(Path(folder), name, [layer.cpu() for layer in linear], activation, squashed=sac)


class DriveVecEnv(VecEnv):
    """`num_envs` rows; infos of rows whose episode ended hold `terminal_observation` and `TimeLimit.truncated`."""

    def __init__(
        self,
        scenarios: str | Path | Sequence[Traffic],
        num_envs: int,
        settings: Settings | None = None,
        of: str | Path | None = None,
        device: str = "cpu",
    ) -> None:
        """See `env.DriveEnv`."""
        self.rows = DriveVectorEnv(scenarios, num_envs, settings, of, device)
        self.render_mode = None
        super().__init__(num_envs, self.rows.single_observation_space, self.rows.single_action_space)
        self._seed: int | None = None

    def reset(self) -> NDArray[np.float32]:
        """Begin an episode in every row; the first time by the seed."""
        seen, _ = self.rows.reset(seed=self._seed)
        self._seed = None
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return seen.copy()

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Scenarios of all rows are drawn by one stream, from the next reset on."""
        self._seed = seed
        return [seed] * self.num_envs

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """One step of all rows; where an episode ends the observation is the first of the next."""
        step = self.rows.advance(self._actions)
        seen, reward, terminated = (tensor.cpu().numpy() for tensor in (step.observation, step.reward, step.terminated))
        truncated = step.truncated.cpu().numpy()
        ended = np.flatnonzero(terminated | truncated)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for r in ended.tolist():
            infos[r] = {"terminal_observation": seen[r].copy(), "TimeLimit.truncated": bool(truncated[r])}
            infos[r] |= {"collision": int(step.kind[r]), "off_road": bool(step.off_road[r]), "left_map": bool(step.left_map[r])}
        if len(ended):
            seen[ended] = self.rows.begin(ended)
        return seen, reward, terminated | truncated, infos

    def close(self) -> None:
        """Nothing is open."""

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """The rows' common attribute, once for each."""
        return [getattr(self.rows, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:  # noqa: ARG002 as the base has them
        """Rows have no attributes of their own to set."""
        raise AttributeError(f"{attr_name} belongs to all rows: give it to DriveVecEnv")

    def env_method(self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any) -> list[Any]:  # noqa: ARG002
        """Rows have no methods of their own."""
        raise AttributeError(f"{method_name}: rows are no environments of their own")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:  # noqa: ARG002
        """No row is wrapped."""
        return [False for _ in self._get_indices(indices)]
