"""Denoising diffusion: noise schedules, and the way back from noise by one of three samplers.

DDPM (Ho and others 2020) adds fresh noise at every step; DDIM (Song and others 2021) and DPM-Solver++ (Lu and others 2022,
its second-order multistep form 2M) solve the same ordinary differential equation without any, to first and second order.
"""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from drivegen.core.errors import UnusableInput

SAMPLERS, SCHEDULES = ("ddpm", "ddim", "dpm_solver"), ("cosine", "linear")

LARGEST = 12.0
"""Estimates of clean states are held within this, in units of the states' scales."""

FAINTEST = 0.003
"""Share of the signal at which fewer steps than all begin where the network predicts noise. The noisiest step of all makes
of its error one of the clean states 450 times as large, which few steps do not forget (LOG.md)."""


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


def kept_steps(schedule: Tensor, count: int, target: str) -> Sequence[int]:
    """`count` of the diffusion steps, evenly spread, from the noisiest (see FAINTEST) down to step 0; a single one is that."""
    last = len(schedule) - 1
    if target == "noise" and count <= last:
        last = max(int((schedule >= FAINTEST).sum()) - 1, count - 1)
    return [last] if count == 1 else [round(k * last / (count - 1)) for k in range(count)][::-1]


def both(output: Tensor, noisy: Tensor, alpha_bar: Tensor, target: str) -> tuple[Tensor, Tensor]:
    """Estimates of clean states and noise from a network that predicts `target`, "noise" or "clean"."""
    signal, noise = alpha_bar.sqrt(), (1 - alpha_bar).sqrt()
    clean = (noisy - noise * output) / signal if target == "noise" else output
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


def second_order_step(
    clean: Tensor, clean_before: Tensor | None, noisy: Tensor, alpha_bar: Tensor, alpha_bar_next: Tensor, alpha_bar_before: Tensor
) -> Tensor:
    """States one kept step less noisy by DPM-Solver++ 2M, from the estimates of clean states here and one step before.

    With lambda = log(signal / noise) and its steps h: x' = noise'/noise x + signal' (1 - e^-h) D, where D goes on from both
    estimates in a straight line in lambda. Without one before, and to noise 0, D is the estimate itself (DDIM's step).
    """
    if clean_before is None or alpha_bar_next >= 1:
        return reverse_step(
            clean, (noisy - alpha_bar.sqrt() * clean) / (1 - alpha_bar).sqrt(), noisy, alpha_bar, alpha_bar_next, None
        )
    before, now, following = (0.5 * torch.log(a / (1 - a)) for a in (alpha_bar_before, alpha_bar, alpha_bar_next))
    step = following - now
    ahead = clean + (clean - clean_before) * step / (2 * (now - before))
    shrunk = ((1 - alpha_bar_next) / (1 - alpha_bar)).sqrt()
    return shrunk * noisy + alpha_bar_next.sqrt() * (1 - torch.exp(-step)) * ahead


def sampled(
    predict: Callable[[Tensor, int], Tensor],
    noise: Callable[[int], Tensor],
    schedule: Tensor,
    count: int,
    target: str,
    sampler: str,
) -> Tensor:
    """Clean states from noise in `count` steps.

    `predict(noisy, step)` is the network, of "noise" or "clean" states as `target` says; `noise(k)` gives independent
    Gaussian noise of the states' shape, k = 0 to begin with; `schedule` are the `alpha_bars`; `sampler` is one of SAMPLERS.
    """
    alpha_bar = torch.cat([schedule, torch.ones(1, device=schedule.device)])
    visited = kept_steps(schedule, count, target)
    x, earlier, before = noise(0), None, visited[0]
    for turn, (now, following) in enumerate(zip(visited, [*visited[1:], -1], strict=True), 1):
        clean, eps = both(predict(x, now), x, alpha_bar[now], target)
        if sampler == "dpm_solver":
            x = second_order_step(clean, earlier, x, alpha_bar[now], alpha_bar[following], alpha_bar[before])
        else:
            fresh = noise(turn) if sampler == "ddpm" else None
            x = reverse_step(clean, eps, x, alpha_bar[now], alpha_bar[following], fresh)
        earlier, before = clean, now
    return x
