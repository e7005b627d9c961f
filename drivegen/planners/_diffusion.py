"""Denoising diffusion: noise schedules, and one reverse step of DDPM (Ho and others 2020) or DDIM (Song and others 2021)."""

from collections.abc import Sequence

import torch
from torch import Tensor

from drivegen.errors import UnusableInput

LARGEST = 12.0
"""Estimates of clean states are held within this, in units of the states' scales."""


def alpha_bars(schedule: str, steps: int) -> Tensor:
    """Share of the signal's variance (steps,) that is left after each step: `cosine` (Nichol, Dhariwal 2021) or `linear`.

    `linear` (betas 1e-4 .. 0.02, made for 1000 steps) leaves a third of the signal after 100 steps: it is there because
    the paper does not say which it used.
    """
    if schedule == "linear":
        betas = torch.linspace(1e-4, 0.02, steps, dtype=torch.float64)
    elif schedule == "cosine":
        t = torch.linspace(0, 1, steps + 1, dtype=torch.float64)
        level = torch.cos((t + 0.008) / 1.008 * torch.pi / 2) ** 2
        betas = (1 - level[1:] / level[:-1]).clamp(max=0.98)
    else:
        raise UnusableInput(f"no noise schedule is called {schedule!r}: choose cosine or linear")
    return torch.cumprod(1 - betas, dim=0).float()


def kept_steps(noise_steps: int, count: int) -> Sequence[int]:
    """`count` of the diffusion steps, evenly spread, from the noisiest down to step 0."""
    return [round(k * (noise_steps - 1) / max(count - 1, 1)) for k in range(count)][::-1]


def both(found: Tensor, noisy: Tensor, alpha_bar: Tensor, target: str) -> tuple[Tensor, Tensor]:
    """Estimates of clean states and noise from a network that predicts `target`, "noise" or "clean"."""
    signal, noise = alpha_bar.sqrt(), (1 - alpha_bar).sqrt()
    clean = (noisy - noise * found) / signal if target == "noise" else found
    clean = clean.clamp(-LARGEST, LARGEST)
    return clean, (noisy - signal * clean) / noise


def reverse_step(
    clean: Tensor, noise: Tensor, noisy: Tensor, alpha_bar: Tensor, alpha_bar_next: Tensor, fresh: Tensor | None
) -> Tensor:
    """States one kept step less noisy; with `fresh` noise it is DDPM's posterior, with None DDIM's (no chance)."""
    if fresh is None:
        return alpha_bar_next.sqrt() * clean + (1 - alpha_bar_next).sqrt() * noise
    alpha = alpha_bar / alpha_bar_next
    weight = alpha_bar_next.sqrt() * (1 - alpha) / (1 - alpha_bar)
    mean = weight * clean + alpha.sqrt() * (1 - alpha_bar_next) / (1 - alpha_bar) * noisy
    return mean + ((1 - alpha) * (1 - alpha_bar_next) / (1 - alpha_bar)).sqrt() * fresh
