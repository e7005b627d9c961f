"""What a driver answered, as worlds take it: a number for every target, or one sentence that says what is wrong."""

from typing import Any

import torch

from drivegen.core.errors import UnusableInput
from drivegen.world.observation import Action


def checked(answer: Any, who: str, speed: torch.Tensor) -> Action:
    """The answer of `who`, its numbers of the kind that `speed` (S,) has.

    Raises UnusableInput for another type or shape, for what is no number, and for steering: targets keep to paths.
    """
    if not isinstance(answer, Action):
        kind = type(answer).__name__
        raise UnusableInput(f"{who}: act(observation) must return drivegen.world.observation.Action, not {kind}")
    if answer.steering is not None:
        raise UnusableInput(f"{who}: act(observation) steers, and drivers keep to paths: give an offset instead")
    acceleration = _numbers("acceleration", answer.acceleration, who, speed)
    return Action(acceleration, None if answer.offset is None else _numbers("offset", answer.offset, who, speed))


def _numbers(name: str, value: Any, who: str, speed: torch.Tensor) -> torch.Tensor:
    if not isinstance(value, torch.Tensor) or value.shape != speed.shape or value.is_complex():
        raise UnusableInput(
            f"{who}: act(observation) must return as {name} a PyTorch tensor with one real number for each of the"
            f" {len(speed)} targets"
        )
    numbers = value.detach().to(speed)
    if not bool(numbers.isfinite().all()):
        raise UnusableInput(f"{who}: act(observation) returns an {name} that is no number")
    return numbers
