"""The native vector environment: rows of one batched world, each reset in the step in which its episode ends."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from drivegen.drivers.shared.conditions import Settings, Traffic
from drivegen.drivers.shared.environment import OBSERVATION, TERMS, Step
from drivegen.gym.opening import opened

Floats = NDArray[np.float32]


class DriveVectorEnv(VectorEnv[Floats, Floats, NDArray[Any]]):
    """`num_envs` rows, each in a scenario drawn anew for every episode.

    Infos hold what each row's reward is made of (`reward/progress`, ...), how an episode ended (`collision`, a `CollisionKind`,
    `off_road`, `left_map`) and its last observation, `final_obs`.
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
        self.render_mode = render_mode
        self.num_envs, self.environment = num_envs, opened(scenarios, num_envs, settings, of, device)
        self.single_observation_space, self.single_action_space = OBSERVATION, self.environment.actions
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode in every row."""
        super().reset(seed=seed, options=options)
        return self.environment.reset(self.environment.draw_scenes(self.num_envs, self.np_random)).cpu().numpy(), {}

    def step(self, actions: Floats) -> tuple[Floats, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """One step; where an episode ends the observation returned is the first of the next, and `final_obs` its last."""
        step = self.advance(actions)
        observation, info = step.observation.cpu().numpy(), self._info(step)
        ended = np.flatnonzero((step.terminated | step.truncated).cpu().numpy())
        if len(ended):
            info |= self._final(observation, ended)
            observation[ended] = self.begin(ended)
        arrays = (step.reward, step.terminated, step.truncated)
        reward, terminated, truncated = (tensor.cpu().numpy() for tensor in arrays)
        return observation, reward, terminated, truncated, info

    def advance(self, actions: Floats) -> Step:
        """One step of all rows, none of which is reset."""
        device = self.environment.world.scene.device
        return self.environment.step(torch.from_numpy(np.array(actions, np.float32).reshape(self.num_envs, -1)).to(device))

    def begin(self, rows: NDArray[np.intp]) -> Floats:
        """New episodes in `rows`; their first observations."""
        index = torch.from_numpy(rows).to(self.environment.world.scene.device)
        return self.environment.reset(self.environment.draw_scenes(len(rows), self.np_random), index).cpu().numpy()

    def _info(self, step: Step) -> dict[str, Any]:
        every = np.ones(self.num_envs, np.bool_)
        terms = {f"reward/{name}": column for name, column in zip(TERMS, step.terms.cpu().numpy().T, strict=True)}
        ends = {"collision": step.kind, "off_road": step.off_road, "left_map": step.left_map}
        values = terms | {name: tensor.cpu().numpy() for name, tensor in ends.items()}
        return {**values, **{f"_{name}": every for name in values}}

    def _final(self, observation: Floats, ended: NDArray[np.intp]) -> dict[str, Any]:
        final = np.full(self.num_envs, None, object)
        mask = np.zeros(self.num_envs, np.bool_)
        for r in ended.tolist():
            final[r] = observation[r].copy()
        mask[ended] = True
        return {"final_obs": final, "_final_obs": mask}
