"""One environment: a target in one scenario after another."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.drivers.shared.conditions import Settings, Traffic
from drivegen.drivers.shared.environment import OBSERVATION, TERMS
from drivegen.gym.opening import begun, opened
from drivegen.gym.picture import picture

Floats = NDArray[np.float32]


class DriveEnv(gymnasium.Env[Any, Any]):
    """`gymnasium.make("DriveGen/Drive-v0", scenarios=FOLDER)`."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 as Gymnasium has it

    def __init__(
        self,
        scenarios: str | Path | Sequence[Traffic],
        settings: Settings | None = None,
        of: str | Path | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Drive in `scenarios`: a folder that drivegen wrote or of Argoverse 2, or pairs of scenario and traffic.

        Without `settings` they are those of params.yaml, section `environment`. `of` is the folder of the scenarios that
        generated samples are futures of. Raises UnusableInput where there is nothing to drive in.
        """
        self.render_mode, self.environment = render_mode, opened(scenarios, 1, settings, of, "cpu")
        self.observation_space, self.action_space = OBSERVATION, self.environment.actions

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begin a scenario drawn by the seed, or number `options["scenario"]` of those that are playable."""
        super().reset(seed=seed)
        scene = begun(self.environment, 1, options, self.np_random)
        features = self.environment.reset(scene)[0].numpy().copy()
        return features, {"scenario": self.environment.traffic[int(scene)][0].scenario_id}

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """One step of 0.1 s."""
        step = self.environment.step(torch.from_numpy(np.array(action, np.float32).reshape(1, -1)))
        info: dict[str, Any] = {f"reward/{name}": float(value) for name, value in zip(TERMS, step.terms[0], strict=True)}
        info |= {"collision": int(step.kind[0]), "off_road": bool(step.off_road[0]), "left_map": bool(step.left_map[0])}
        features = step.observation[0].numpy().copy()
        return features, float(step.reward[0]), bool(step.terminated[0]), bool(step.truncated[0]), info

    def render(self) -> NDArray[np.uint8] | None:
        """(H, W, 3) the target in the middle, from above; None unless made with "rgb_array"."""
        return picture(self.environment) if self.render_mode == "rgb_array" else None
