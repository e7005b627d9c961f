"""Fine-tuning: a pupil goes on in other traffic with all that another one has learnt so far."""

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import torch
from torch import nn
from torch.optim import Optimizer

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import build, file_of
from drivegen.drivers.shared.conditions import Traffic
from drivegen.drivers.shared.lessons import Grade, Lessons
from drivegen.drivers.shared.policy import Policy
from drivegen.drivers.shared.teaching import Pupil, Taught, teach
from drivegen.training.checkpoint import Part

Say = Callable[[str], None]


@dataclass(frozen=True)
class How:
    """How a driver is taught on logs (`base`) and `tuned`, each as its `lessons_type` says."""

    base: Any
    tuned: Any

    @classmethod
    def of(cls, name: str, drivers: Mapping[str, Mapping[str, Any]], section: str) -> Self:
        """By each driver's settings in a section of the parameters; raises UnusableInput where the driver `name` has none."""
        if name not in drivers or drivers[name].keys() != {"base", "tuned"}:
            raise UnusableInput(f"{file_of(section)}: {section} has no settings `base` and `tuned` for {name!r}")
        kind, place = plugins.load("drivers", name).lessons_type(), f"{file_of(section)}: {section}.{name}"
        return cls(**{key: build(kind, value, f"{place}.{key}") for key, value in drivers[name].items()})


class Tuner:
    """Teaches a driver on logs, then tunes it from there, as often as it is asked to, each time anew and for as long.

    Attributes:
        base: the policy that was taught on logs. grades: how it drove in validation scenes on the way.
    """

    def __init__(self, plugin: type[Taught], how: How, logs: Lessons, validation: Lessons, seed: int, say: Say) -> None:
        self._plugin, self._tuned, self._validation, self._seed = plugin, how.tuned, validation, seed
        self._pupil = plugin.pupil(how.base, logs, seed)
        self.base, self.grades = teach(self._pupil, how.base.course, validation, seed, None, say)
        stand_at(self._pupil, self.base)

    def tune(self, lessons: Lessons, say: Say) -> tuple[Policy, list[Grade]]:
        """The policy that drives best in the validation scenes of those met on the way, and how each drove there."""
        pupil = Continued(self._pupil, self._plugin.pupil(self._tuned, lessons, self._seed))
        return teach(pupil, self._tuned.course, self._validation, self._seed, None, say)


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


def mixed(logs: Sequence[Traffic], cases: Sequence[Traffic], share: float) -> list[Traffic]:
    """All logs and, over and over, `cases` until these are `share` (below 1) of the whole; only logs where there is no case."""
    count = round(share / (1 - share) * len(logs)) if cases else 0
    return [*logs, *(cases[i % len(cases)] for i in range(count))]


def exemplary(traffic: Sequence[Traffic]) -> list[Traffic]:
    """Those in which the target's own motion, driven as drivers drive, ends in no collision."""
    crashed = Lessons.of(traffic).demonstrations().crashed if traffic else ()
    return [one for one, ended in zip(traffic, crashed, strict=True) if not ended]


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
