"""The batched world as Stable-Baselines3's `VecEnv`."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from drivegen.drivers.shared.environment import OBSERVATION, Environment

Indices = int | Iterable[int] | None


class WorldVecEnv(VecEnv):
    """All rows of `environment`; infos of those whose episode ended hold `terminal_observation` and `TimeLimit.truncated`."""

    def __init__(self, environment: Environment) -> None:
        self.environment, self.render_mode = environment, None
        super().__init__(len(environment.world.scene), OBSERVATION, environment.actions)
        self._random = np.random.default_rng()

    def reset(self) -> NDArray[np.float32]:
        """Begin an episode in every row."""
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return self.environment.reset(self.environment.draw_scenes(self.num_envs, self._random)).cpu().numpy()

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Scenarios of all rows are drawn by one stream, which begins anew."""
        self._random = np.random.default_rng(seed)
        return [seed] * self.num_envs

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """One step of all rows; where an episode ends the observation is the first of the next."""
        device = self.environment.world.scene.device
        step = self.environment.step(self.environment.actions_of(self._actions))
        features, reward, terminated = (tensor.cpu().numpy() for tensor in (step.observation, step.reward, step.terminated))
        truncated, kind, off_road, left_map = (
            tensor.cpu().numpy() for tensor in (step.truncated, step.kind, step.off_road, step.left_map)
        )
        ended = np.flatnonzero(terminated | truncated)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for r in ended.tolist():
            infos[r] = {"terminal_observation": features[r].copy(), "TimeLimit.truncated": bool(truncated[r])}
            infos[r] |= {"collision": int(kind[r]), "off_road": bool(off_road[r]), "left_map": bool(left_map[r])}
        if len(ended):
            scenes = self.environment.draw_scenes(len(ended), self._random)
            features[ended] = self.environment.reset(scenes, torch.from_numpy(ended).to(device)).cpu().numpy()
        return features, reward, terminated | truncated, infos

    def close(self) -> None:
        """Nothing is open."""

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """The rows' common attribute, once for each."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:  # noqa: ARG002 as the base has them
        """Rows have no attributes of their own to set."""
        raise AttributeError(f"{attr_name} belongs to all rows: give it to the environment")

    def env_method(self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any) -> list[Any]:  # noqa: ARG002
        """Rows have no methods of their own."""
        raise AttributeError(f"{method_name}: rows are no environments of their own")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:  # noqa: ARG002
        """No row is wrapped."""
        return [False for _ in self._get_indices(indices)]
