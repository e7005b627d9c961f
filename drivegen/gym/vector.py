"""The native vector environment: rows of one batched world, each reset in the step in which its episode ends."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.conditions import Settings, Traffic
from drivegen.drivers.shared.environment import OBSERVATION, TERMS, Step
from drivegen.gym.opening import begun, opened

Floats = NDArray[np.float32]


class DriveVectorEnv(VectorEnv[Floats, Floats, NDArray[Any]]):
    """`num_envs` rows, each in a scenario drawn anew for every episode.

    Infos hold what each row's reward is made of (`reward/progress`, ...), how an episode ended (`collision`, a `CollisionKind`,
    `off_road`, `left_map`), and of rows that begin an episode the id of its `scenario`. Where episodes end, `final_obs` and
    `final_info` have what was last seen and said of them.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012 as Gymnasium has it

    def __init__(
        self,
        scenarios: str | Path | Sequence[Traffic],
        num_envs: int = 1,
        settings: Settings | None = None,
        of: str | Path | None = None,
        device: str = "cpu",
        render_mode: None = None,
    ) -> None:
        """See `env.DriveEnv`."""
        if render_mode is not None:
            raise UnusableInput(f"render_mode is {render_mode!r}: many rows have no picture, gymnasium.make with one has")
        self.render_mode = render_mode
        self.num_envs, self.environment = num_envs, opened(scenarios, num_envs, settings, of, device)
        self.single_observation_space, self.single_action_space = OBSERVATION, self.environment.actions
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode in every row, in scenarios drawn by the seed or in those that options name: see `opening.begun`."""
        super().reset(seed=seed, options=options)
        scenes = begun(self.environment, self.num_envs, options, self.np_random)
        return self.environment.reset(scenes).cpu().numpy(), self._begun(np.ones(self.num_envs, np.bool_))

    def step(self, actions: Floats) -> tuple[Floats, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """One step; where an episode ends the observation returned is the first of the next, and `final_obs` its last."""
        environment = self.environment
        step = environment.step(environment.actions_of(actions))
        observation, info = step.observation.cpu().numpy(), self._info(step)
        arrays = (step.reward, step.terminated, step.truncated)
        reward, terminated, truncated = (tensor.cpu().numpy() for tensor in arrays)
        ended = terminated | truncated
        if ended.any():
            info |= self._final(observation, info, ended)
            rows = torch.from_numpy(np.flatnonzero(ended)).to(environment.world.scene.device)
            scenes = environment.draw_scenes(len(rows), self.np_random)
            observation[ended] = environment.reset(scenes, rows).cpu().numpy()
            info |= self._begun(ended)
        return observation, reward, terminated, truncated, info

    def _info(self, step: Step) -> dict[str, Any]:
        every = np.ones(self.num_envs, np.bool_)
        terms = {f"reward/{name}": column for name, column in zip(TERMS, step.terms.cpu().numpy().T, strict=True)}
        ends = {"collision": step.kind, "off_road": step.off_road, "left_map": step.left_map}
        values = terms | {name: tensor.cpu().numpy() for name, tensor in ends.items()}
        return {**values, **{f"_{name}": every for name in values}}

    def _final(self, observation: Floats, info: dict[str, Any], ended: NDArray[np.bool_]) -> dict[str, Any]:
        final = np.full(self.num_envs, None, object)
        for r in np.flatnonzero(ended).tolist():
            final[r] = observation[r].copy()
        said = {name: ended if name.startswith("_") else values for name, values in info.items()}
        return {"final_obs": final, "_final_obs": ended, "final_info": said, "_final_info": ended}

    def _begun(self, rows: NDArray[np.bool_]) -> dict[str, Any]:
        """Which scenarios `rows` (R,) are in."""
        scenario = np.full(self.num_envs, None, object)
        scene = self.environment.world.scene.cpu().numpy()
        for r in np.flatnonzero(rows).tolist():
            scenario[r] = self.environment.traffic[scene[r]][0].scenario_id
        return {"scenario": scenario, "_scenario": rows}
