"""Conditional flow matching in a whitened latent space (Lipman and others 2023, straight paths), with a small ResMLP.

Training: z_t = (1 - t) z_0 + t z_1 between noise z_0 and data z_1; the network learns the velocity z_1 - z_0.
Sampling: Euler steps from noise at t = 0 to t = 1.
"""

import torch
from torch import Tensor, nn

TIME_WAVES = 16
"""Frequencies of the time embedding; its width is twice that."""


class FlowNet(nn.Module):
    """Velocity of latents (B, Z) at times t (B,) given a context (B, H): residual blocks with FiLM from both.

    `context(features)` is computed once per request, the blocks once per step. The context's and the time's shares of
    FiLM are added, so at sampling time the first is computed once, too. `encode` makes features (B, F) into (B, width).
    """

    def __init__(self, encode: nn.Module, latent: int, width: int, blocks: int, dropout: float) -> None:
        super().__init__()
        self.encode = encode
        self.drop = nn.Dropout(dropout)
        self.film = nn.Linear(width, 2 * width * blocks)
        self.time = nn.Sequential(nn.Linear(2 * TIME_WAVES, width), nn.SiLU(), nn.Linear(width, 2 * width * blocks))
        self.enter = nn.Linear(latent, width)
        self.norms = nn.ModuleList(nn.LayerNorm(width, elementwise_affine=False) for _ in range(blocks))
        self.inner = nn.ModuleList(nn.Linear(width, width) for _ in range(blocks))
        self.outer = nn.ModuleList(nn.Linear(width, width) for _ in range(blocks))
        self.leave = nn.Linear(width, latent)
        nn.init.zeros_(self.leave.weight)
        nn.init.zeros_(self.leave.bias)
        self.register_buffer("waves", torch.exp(torch.linspace(0.0, 5.0, TIME_WAVES)), persistent=False)

    def context(self, features: Tensor) -> Tensor:
        """The requests' share of FiLM (B, 2 * width * blocks) from their features (B, F)."""
        return torch.as_tensor(self.film(self.encode(features)))

    def velocity(self, z: Tensor, t: Tensor, context: Tensor) -> Tensor:
        """(B, Z); t is (B,) or (1,)."""
        angle = t[:, None] * torch.as_tensor(self.waves)
        film = (context + self.time(torch.cat([angle.sin(), angle.cos()], dim=-1))).chunk(2 * len(self.inner), dim=-1)
        h = self.enter(z)
        for k, (norm, inner, outer) in enumerate(zip(self.norms, self.inner, self.outer, strict=True)):
            h = h + outer(self.drop(nn.functional.silu(inner(norm(h) * (1 + film[2 * k]) + film[2 * k + 1]))))
        return torch.as_tensor(self.leave(h))

    def forward(self, features: Tensor, z1: Tensor, noise: Tensor, t: Tensor) -> Tensor:
        """Squared velocity errors (B, M, Z) for M draws of noise (B, M, Z) and t (B, M) per example."""
        draws = noise.shape[1]
        context = self.context(features).repeat_interleave(draws, dim=0)
        goal = z1[:, None].expand_as(noise)
        z = (1 - t[..., None]) * noise + t[..., None] * goal
        velocity = self.velocity(z.flatten(0, 1), t.flatten(), context).float().view_as(noise)
        return torch.as_tensor((velocity - (goal - noise)).square())

    def sample(self, features: Tensor, noise: Tensor, steps: int) -> Tensor:
        """Latents (B, Z) by `steps` Euler steps from `noise` (B, Z)."""
        context, z = self.context(features), noise
        for k in range(steps):
            z = z + self.velocity(z, torch.full((1,), k / steps, device=z.device), context) / steps
        return torch.as_tensor(z)


def dense_encoder(features: int, width: int, dropout: float) -> nn.Sequential:
    """Two layers for features that are a plain list of numbers."""
    return nn.Sequential(
        nn.Dropout(dropout), nn.Linear(features, width), nn.SiLU(), nn.Dropout(dropout), nn.Linear(width, width), nn.SiLU()
    )


class FlowObjective:
    """The flow matching loss over examples with `features` (E, F) and latents `z1` (E, Z).

    `draws` noises are drawn per example and step: the context is computed once for all of them.
    """

    def __init__(
        self, features: Tensor, latents: Tensor, weight: Tensor, draws: int, validation: tuple[Tensor, Tensor], seed: int
    ) -> None:
        self.features, self.latents, self.weight, self.draws = features, latents, weight, draws
        self.held_out = validation
        self.noise = self.draw(len(validation[0]), torch.Generator().manual_seed(seed))
        self.size = len(features)

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """Noise (rows, draws, Z) and times (rows, draws), denser in the middle (logit-normal)."""
        noise = torch.randn(rows, self.draws, self.latents.shape[1], generator=generator)
        return noise, torch.randn(rows, self.draws, generator=generator).sigmoid()

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        """Weighted mean squared velocity error."""
        return torch.as_tensor((model(self.features[rows], self.latents[rows], *drawn) * self.weight).mean())

    def validation(self, model: nn.Module) -> float:
        """The same on the validation examples, with noise drawn once."""
        features, latents = self.held_out
        if len(features) == 0:
            return float("nan")
        noise = (n.to(features.device) for n in self.noise)
        return float((model(features, latents, *noise) * self.weight).mean())
