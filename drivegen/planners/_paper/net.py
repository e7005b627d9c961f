"""The paper's network (Methodology, "Scenario Rollout" and its planner figure): raster CNN, transformer, affine fusion."""

from itertools import pairwise

import torch
from torch import Tensor, nn

RASTER_WIDTHS = (32, 64, 128, 256)
"""Channels after each of the CNN's four layers; the paper gives their number only."""


class PaperNet(nn.Module):
    """Predicts noise (or x0) for noisy states (B, T, S) from initial state (B, S), goal (B, S), raster code and step.

    Tokens are [s_0, tau_1 ... tau_T, s_goal]. Each of the `layers` blocks is self-attention, affine fusion
    X' = X * W + B with W, B two 2-layer MLPs of (m, t_d), then the feed-forward network, with residuals and
    normalisation before each as usual. The paper says nothing on the head, on positions (learnt here) and on the
    feed-forward width (four times `width`).
    """

    def __init__(self, channels: int, state: int, tokens: int, width: int, heads: int, layers: int, noise_steps: int) -> None:
        super().__init__()
        self.raster = _RasterCode(channels, width)
        self.enter = nn.Linear(state, width)
        self.place = nn.Parameter(torch.randn(tokens + 2, width) * 0.02)
        self.time = nn.Embedding(noise_steps, width)
        self.blocks = nn.ModuleList(_FusionBlock(width, heads) for _ in range(layers))
        self.norm = nn.LayerNorm(width)
        self.leave = nn.Linear(width, state)

    def forward(self, noisy: Tensor, start: Tensor, goal: Tensor, pictures: Tensor, step: Tensor) -> Tensor:
        """(B, T, S) for diffusion steps (B,) and rasters (B, C, 256, 256) uint8."""
        return self.denoise(noisy, start, goal, self.raster(pictures), step)

    def denoise(self, noisy: Tensor, start: Tensor, goal: Tensor, code: Tensor, step: Tensor) -> Tensor:
        """The same for raster codes (B, width) of `self.raster`, which don't change from step to step."""
        x = self.enter(torch.cat([start[:, None], noisy, goal[:, None]], dim=1)) + self.place
        condition = torch.cat([code, self.time(step)], dim=-1)
        for block in self.blocks:
            x = block(x, condition)
        return torch.as_tensor(self.leave(self.norm(x[:, 1:-1])))


class _RasterCode(nn.Module):
    """Four convolutions of stride 2 over (B, C, 256, 256) uint8, averaged over what is left of the picture."""

    def __init__(self, channels: int, width: int) -> None:
        super().__init__()
        widths = (channels, *RASTER_WIDTHS)
        layers = [
            nn.Sequential(nn.Conv2d(a, b, 3, stride=2, padding=1), nn.GroupNorm(8, b), nn.SiLU()) for a, b in pairwise(widths)
        ]
        self.layers = nn.Sequential(*layers)
        self.leave = nn.Linear(widths[-1], width)

    def forward(self, raster: Tensor) -> Tensor:
        """Map information m (B, width)."""
        return torch.as_tensor(self.leave(self.layers(raster.float() / 255).mean(dim=(2, 3))))


class _FusionBlock(nn.Module):
    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.norms = nn.ModuleList(nn.LayerNorm(width) for _ in range(2))
        self.mixed, self.joined = nn.Linear(width, 3 * width), nn.Linear(width, width)
        self.scale, self.shift = _mlp(width, 1.0), _mlp(width, 0.0)  # begins as X' = X
        self.forward_net = nn.Sequential(nn.Linear(width, 4 * width), nn.GELU(), nn.Linear(4 * width, width))

    def forward(self, x: Tensor, condition: Tensor) -> Tensor:
        count, tokens, width = x.shape
        q, k, v = self.mixed(self.norms[0](x)).view(count, tokens, 3, self.heads, -1).permute(2, 0, 3, 1, 4)
        attended = nn.functional.scaled_dot_product_attention(q, k, v).transpose(1, 2).reshape(count, tokens, width)
        x = x + self.joined(attended)
        x = x * self.scale(condition)[:, None] + self.shift(condition)[:, None]
        return torch.as_tensor(x + self.forward_net(self.norms[1](x)))


def _mlp(width: int, level: float) -> nn.Sequential:
    """A 2-layer MLP of (m, t_d) that begins near `level` everywhere."""
    last = nn.Linear(width, width)
    nn.init.normal_(last.weight, std=0.01)
    nn.init.constant_(last.bias, level)
    return nn.Sequential(nn.Linear(2 * width, width), nn.SiLU(), last)
