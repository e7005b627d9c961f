"""Fine-tuning: a pupil goes on in other traffic with all that another one has learnt so far."""

import copy
from collections.abc import Mapping

import torch
from torch import nn
from torch.optim import Optimizer

from drivegen.drivers.shared.policy import Policy
from drivegen.drivers.shared.teaching import Pupil
from drivegen.training.checkpoint import Part


class Continued:
    """A pupil that begins where `base` stands; see `teaching.Pupil`.

    Networks, what is learnt beside them and the moments of optimisers go over; what `base` lived through (a replay buffer) and
    its learning rates do not.
    """

    def __init__(self, base: Pupil, pupil: Pupil) -> None:
        self._base, self._pupil = base, pupil
        self.policy: Policy = pupil.policy
        self.tries: Policy = pupil.tries

    @property
    def parts(self) -> Mapping[str, Part]:
        """See `teaching.Pupil`."""
        return self._pupil.parts

    def begin(self, seed: int) -> None:  # noqa: ARG002 as every pupil's
        """Take over."""
        for name, part in self._pupil.parts.items():
            _take_over(part, self._base.parts[name])

    def study(self, number: int, seed: int) -> None:
        """See `teaching.Pupil`."""
        self._pupil.study(number, seed)


def stand_at(pupil: Pupil, policy: Policy) -> None:
    """Let `pupil` go on from `policy`, which one of its rounds was, instead of from its last round."""
    for network in (pupil.policy, pupil.tries):
        network.layers.load_state_dict(policy.layers.state_dict())


def _take_over(part: Part, learnt: Part) -> None:
    if isinstance(part, nn.Module) and isinstance(learnt, nn.Module):
        part.load_state_dict(learnt.state_dict())
    elif isinstance(part, Optimizer) and isinstance(learnt, Optimizer):
        rates = [group["lr"] for group in part.param_groups]
        part.load_state_dict(copy.deepcopy(learnt.state_dict()))
        for group, rate in zip(part.param_groups, rates, strict=True):
            group["lr"] = rate
    elif isinstance(part, torch.Tensor) and isinstance(learnt, torch.Tensor) and part.requires_grad:
        with torch.no_grad():
            part.copy_(learnt)
