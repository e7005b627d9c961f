"""Planner `paper`: the diffusion transformer as the paper writes it, on a raster of the map, for comparison.

What the paper gives: a 4-layer CNN on a 256x256 vehicle-centric raster, a 3-layer transformer of width 256 with 4 heads,
affine fusion X' = X * W + B by two 2-layer MLPs of (m, t_d) between self-attention and feed-forward network, prediction
of the noise given tau_t, s_0, s_goal, t_d, 100 diffusion steps, 90 epochs, learning rate 1e-4, batch size 32.

What it leaves open, and what each setting here chooses:
  * the state vector: `state` "pose" (x, y, cos h, sin h, v) or "position" (x, y; heading and speed from differences);
  * raster channels and extent: `channels`, `extent`;
  * the noise schedule: `schedule` cosine or linear;
  * how it samples: `sampler` ddpm, ddim or dpm_solver (DPM-Solver++ 2M), `sampling_steps`;
  * what is predicted when not noise: `target`;
  * whether 32 counts trajectories or scenarios: `batch_of`;
  * widths of the CNN, positions, head: see `_paper.net`; optimiser (AdamW, constant rate) and the moving average of weights:
    `training`. It says nothing of a moving average, so the default is none.
States are in the vehicle's frame at step 0. Tokens run from step 1 to the goal's step, so shorter tracks are stretched
to the same number of tokens. The goal is a condition, not a guarantee; the first frame is the initial state itself.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import Count, Positive, build, expect_multiple
from drivegen.planners._paper.diffusion import SAMPLERS, SCHEDULES, alpha_bars, sampled
from drivegen.planners._paper.examples import DiffusionObjective, Rasters
from drivegen.planners._paper.net import PaperNet
from drivegen.planners._paper.states import SCALES, conditions, from_states
from drivegen.planners.base import Examples, PlanRequests
from drivegen.planners.shared.noise import normals
from drivegen.planners.shared.scores import drawn_tracks, probe
from drivegen.roads.raster import CHANNELS
from drivegen.training import loop
from drivegen.training.curve import LossRow
from drivegen.training.weights import fill, read_weights, write_weights

CHUNK = {"cpu": 32, "cuda": 1024}
"""Requests that go through the network at once, always: sums differ between batch sizes."""

PICTURES = {"cpu": 1, "cuda": 64}
"""Rasters that are encoded at once, always."""

WATCHED = 32
"""Validation tracks that are planned at each row of the loss curve."""


@dataclass(frozen=True)
class PaperSettings:
    """Values stand in params.yaml, `train_planner.planners.paper`; see the module for what the paper leaves open.

    Attributes:
        state: "pose" or "position". tokens: T, states between start and goal, the goal's own step included; with "pose" even.
        width, heads, layers: of the transformer; `width` is a multiple of `heads`. noise_steps: diffusion steps.
        schedule: "cosine" or "linear". target: "noise" or "clean". sampler: see `_paper.diffusion.SAMPLERS`.
        sampling_steps: of the noise steps, those that sampling visits. batch_of: "trajectories" or "scenarios".
        channels: see `roads.raster.CHANNELS`. extent: [m] side of the raster. bf16: sample in bfloat16, too.
        training: see `training.loop.Settings`; 90 epochs are 90 * examples / batch steps.
    """

    state: str
    tokens: Count
    width: Count
    heads: Count
    layers: Count
    noise_steps: Count
    schedule: str
    target: str
    sampler: str
    sampling_steps: Count
    batch_of: str
    channels: tuple[str, ...]
    extent: Positive
    bf16: bool
    training: loop.Settings

    def __post_init__(self) -> None:
        place = "train_planner.planners.paper"
        words = {
            "state": tuple(SCALES),
            "schedule": SCHEDULES,
            "target": ("noise", "clean"),
            "sampler": SAMPLERS,
            "batch_of": ("trajectories", "scenarios"),
        }
        for name, allowed in words.items():
            _expect_word(f"{place}.{name}", getattr(self, name), allowed)
        for channel in self.channels:
            _expect_word(f"{place}.channels", channel, CHANNELS)
        if self.sampling_steps > self.noise_steps:
            raise UnusableInput(
                f"{place}.sampling_steps must be at most noise_steps, {self.noise_steps}, not {self.sampling_steps}"
            )
        expect_multiple(f"{place}.width", self.width, self.heads, "heads")
        if len(SCALES[self.state]) % 2:  # noise comes in pairs
            expect_multiple(f"{place}.tokens", self.tokens, 2)


def _expect_word(place: str, word: str, allowed: Sequence[str]) -> None:
    if word not in allowed:
        raise UnusableInput(f"{place} must be one of {', '.join(allowed)}, not {word!r}")


class Plugin:
    """See `planners.base.Planner`."""

    Settings = PaperSettings

    def __init__(self, settings: PaperSettings) -> None:
        self.settings, self.trained, self.learnt_from = settings, False, 0
        self.net = self._new_net()

    def fit(
        self, train: Iterable[Examples], validation: Examples, seed: int, checkpoints: Path | None, report: Callable[[str], None]
    ) -> list[LossRow]:
        """See `planners.base.Planner`. All of `train` is held in memory, with its maps."""
        torch.manual_seed(seeds.derive(seed, "network"))
        learnt = Examples.join(list(train))
        settings, device = self.settings, loop.device()
        alpha_bar = alpha_bars(settings.schedule, settings.noise_steps).to(device)
        objective = DiffusionObjective(
            learnt[~learnt.requests.parked], validation[~validation.requests.parked], alpha_bar, settings.target, settings.state,
            settings.tokens, settings.batch_of, settings.channels, settings.extent, seeds.derive(seed, "validation"),
        )  # fmt: skip
        path = None if checkpoints is None else checkpoints / "paper.safetensors"
        tracks = drawn_tracks(validation, WATCHED, None, seed)

        def watched(net: PaperNet) -> float:
            self.net, self.trained = net, True
            return probe(self.sample, validation, tracks, seed)

        self.learnt_from = objective.size
        averaged, curve = loop.train(self._new_net().to(device), objective, settings.training, seed, path, report, probe=watched)
        self.net, self.trained = averaged.cpu().eval(), True
        return curve

    def sample(self, scenarios: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        """See `planners.base.Planner`. Goals are approached, not met exactly; raises UnusableInput if never trained."""
        if not self.trained:
            raise UnusableInput("planner paper has not been trained", reason="untrained")
        horizon = np.array([s.steps for s in scenarios])[requests.scenario]
        if not len(requests):
            return Trajectories.empty(0, 1)
        states = np.empty((len(requests), self.settings.tokens, len(SCALES[self.settings.state])), np.float32)
        rasters = Rasters(scenarios, self.settings.channels, self.settings.extent)
        torch.set_num_threads(1)
        device = loop.device()
        net, chunk = self.net.to(device), CHUNK[device.type]
        with torch.inference_mode(), torch.autocast(device.type, torch.bfloat16, enabled=self.settings.bf16):
            codes = self._codes(net, rasters, requests, device)
            for low in range(0, len(requests), chunk):
                count = min(chunk, len(requests) - low)
                padded = np.resize(np.arange(low, low + count), chunk)
                states[low : low + count] = self._denoised(net, requests[padded], codes[padded], device)[:count]
        return from_states(states, requests, self.settings.state, horizon)

    def save(self, folder: Path) -> None:
        """See `planners.base.Planner`."""
        write_weights(
            folder, "planner", "paper", asdict(self.settings), {k: v.numpy() for k, v in self.net.cpu().state_dict().items()}
        )

    @classmethod
    def load(cls, folder: Path) -> Self:
        """See `planners.base.Planner`."""
        values, tensors = read_weights(folder, "planner", "paper")
        planner = cls(build(PaperSettings, values, f"{folder}"))
        fill(planner.net, tensors, folder)
        planner.net.eval()
        planner.trained = True
        return planner

    def _new_net(self) -> PaperNet:
        s = self.settings
        return PaperNet(len(s.channels), len(SCALES[s.state]), s.tokens, s.width, s.heads, s.layers, s.noise_steps)

    def _codes(self, net: PaperNet, rasters: Rasters, requests: PlanRequests, device: torch.device) -> Tensor:
        """Raster codes (B, width): each vehicle's map is drawn and encoded once."""
        who = np.column_stack([requests.scenario, requests.vehicle])
        _, first, inverse = np.unique(who, axis=0, return_index=True, return_inverse=True)
        size = PICTURES[device.type]
        padded = np.resize(first, -(-len(first) // size) * size)
        codes = [net.raster(torch.from_numpy(rasters.of(requests[some])).to(device)) for some in padded.reshape(-1, size)]
        return torch.cat(codes)[torch.from_numpy(inverse.reshape(-1)).to(device)]

    def _denoised(self, net: PaperNet, requests: PlanRequests, code: Tensor, device: torch.device) -> NDArray[np.float32]:
        """Scaled states (b, T, S) of a chunk, sampled from noise."""
        settings = self.settings
        shape = (len(requests), settings.tokens, len(SCALES[settings.state]))
        start, goal = (torch.from_numpy(a).to(device) for a in conditions(requests, settings.state))

        def noise(stream: int) -> Tensor:
            return torch.from_numpy(normals(requests.seed, shape[1] * shape[2], stream).reshape(shape)).to(device)

        def predict(noisy: Tensor, step: int) -> Tensor:
            return net.denoise(noisy, start, goal, code, torch.full((len(noisy),), step, device=device)).float()

        schedule = alpha_bars(settings.schedule, settings.noise_steps).to(device)
        x = sampled(predict, noise, schedule, settings.sampling_steps, settings.target, settings.sampler)
        return np.asarray(x.float().cpu().numpy())
