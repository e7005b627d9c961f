"""The three samplers of diffusion lead from noise to data whose distribution is known; fewer steps cost the second order less."""

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from drivegen.core.errors import UnusableInput
from drivegen.planners._paper.diffusion import SAMPLERS, alpha_bars, kept_steps, reverse_step, sampled, second_order_step
from drivegen.planners.paper import Plugin
from tests.planners.test_planners_contract import same
from tests.planners.tiny import examples, tiny

MEAN, SPREAD = torch.tensor([1.5, -0.5]), torch.tensor([0.5, 0.2])
SCHEDULE = alpha_bars("cosine", 100)


def best_guess(noisy: Tensor, step: int) -> Tensor:
    """The mean of Gaussian data given their noisy version: what a perfect network says."""
    level = SCHEDULE[step]
    gain = level.sqrt() * SPREAD**2 / (level * SPREAD**2 + 1 - level)
    return MEAN + gain * (noisy - level.sqrt() * MEAN)


def its_noise(noisy: Tensor, step: int) -> Tensor:
    return (noisy - SCHEDULE[step].sqrt() * best_guess(noisy, step)) / (1 - SCHEDULE[step]).sqrt()


def noise(stream: int) -> Tensor:
    return torch.randn(20_000, 2, generator=torch.Generator().manual_seed(stream))


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize(("target", "predict"), [("clean", best_guess), ("noise", its_noise)])
def test_with_a_perfect_network_samples_have_the_data_s_distribution(sampler, target, predict):
    found = sampled(predict, noise, SCHEDULE, 100, target, sampler)
    torch.testing.assert_close(found.mean(0), MEAN, atol=0.03, rtol=0)
    torch.testing.assert_close(found.std(0), SPREAD, atol=0.03, rtol=0)


def test_twice_the_steps_halve_the_first_order_s_error_and_quarter_the_second_s():
    truth = sampled(best_guess, noise, SCHEDULE, 100, "clean", "dpm_solver")

    def error(sampler: str, steps: int) -> float:
        return float((sampled(best_guess, noise, SCHEDULE, steps, "clean", sampler) - truth).square().mean().sqrt())

    assert error("dpm_solver", 25) < 0.6 * error("ddim", 25)
    assert error("ddim", 50) == pytest.approx(error("ddim", 25) / 2, rel=0.2)
    assert error("dpm_solver", 50) < error("dpm_solver", 25) / 3


def test_few_steps_forgive_a_network_that_errs():
    found = sampled(lambda noisy, step: its_noise(noisy, step) + 0.02, noise, SCHEDULE, 10, "noise", "ddim")
    assert (found.mean(0) - MEAN).abs().max() < 0.3


def test_a_single_step_is_taken_from_pure_noise():
    assert list(kept_steps(SCHEDULE, 1, "clean")) == [99]
    assert list(kept_steps(SCHEDULE, 3, "clean")) == [99, 50, 0]
    assert list(kept_steps(SCHEDULE, 100, "noise")) == [*range(99, -1, -1)]
    assert list(kept_steps(SCHEDULE, 3, "noise")) == [95, 48, 0]
    assert list(kept_steps(SCHEDULE[:1], 1, "noise")) == [0]
    guessed = sampled(best_guess, noise, SCHEDULE, 1, "clean", "ddim")
    torch.testing.assert_close(guessed.mean(0), MEAN, atol=0.03, rtol=0)


def test_without_an_earlier_estimate_the_second_order_step_is_ddim_s():
    noisy, clean = noise(0)[:5], noise(1)[:5]
    now, following = SCHEDULE[60], SCHEDULE[50]
    eps = (noisy - now.sqrt() * clean) / (1 - now).sqrt()
    torch.testing.assert_close(
        second_order_step(clean, None, noisy, now, following, now), reverse_step(clean, eps, noisy, now, following, None)
    )
    # an estimate that does not change adds nothing to it
    torch.testing.assert_close(
        second_order_step(clean, clean, noisy, now, following, SCHEDULE[70]),
        reverse_step(clean, eps, noisy, now, following, None),
        atol=1e-4, rtol=1e-4,
    )  # fmt: skip


def test_the_paper_s_planner_samples_by_all_three_and_refuses_a_fourth():
    logs = examples(1)
    planner = tiny("paper")
    planner.fit([logs], logs[:2], 7, None, lambda line: None)
    found = []
    for sampler in SAMPLERS:
        planner.settings = replace(planner.settings, sampler=sampler)
        found.append(planner.sample(logs.scenarios, logs.requests))
        found[-1].validate()
    assert not same(found[0], found[1])
    assert not same(found[1], found[2])
    with pytest.raises(UnusableInput, match="sampler must be one of ddpm, ddim, dpm_solver"):
        Plugin(replace(planner.settings, sampler="guess"))
