"""The mutated drivers: 24 faulty ones and 8 equivalent ones, each a sound driver seen through one row of this table.

A fault changes what the driver sees or what becomes of its action, row by row, and remembers nothing from step to step.
An equivalent one takes another way to what the sound one does, and should be ranked beside it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import torch
from torch import Tensor

from drivegen.core.errors import UnusableInput
from drivegen.drivers.base import Driver, RuleDriver
from drivegen.drivers.mutants.views import in_double_precision, mirrored, of_others, of_rows, without
from drivegen.world.observation import Action, Observation


def _as_it_is(seen: Observation) -> Observation:
    return seen


def _as_meant(action: Action, _: Observation) -> Action:
    return action


@dataclass(frozen=True)
class Mutation:
    """One row.

    Attributes:
        line: what is wrong with the driver, or by which way it does the same, in a plain sentence.
        see: what it sees of an observation. do: what becomes of its action, given what there was to see.
        fails: the kinds of collisions (`corner_cases.kinds.Kind`) that it should have by what is wrong with it, declared before
            it was driven; none of an equivalent one.
    """

    line: str
    see: Callable[[Observation], Observation] = _as_it_is
    do: Callable[[Action, Observation], Action] = _as_meant
    fails: tuple[str, ...] = ()


def _gap(seen: Observation) -> Tensor:
    """(S, M) [m] between the target's front and the others' rears, along the path."""
    return seen.ahead - seen.half_length - 0.5 * seen.length[:, None]


def _time_left(seen: Observation) -> Tensor:
    """(S, M) [s] until the gap is closed at present speeds; inf where it opens."""
    closing = seen.speed[:, None] - seen.speed_along
    return torch.where(closing > 0, _gap(seen) / closing, torch.inf)


def _beside(seen: Observation) -> Tensor:
    """(S, M) [m] the others' middles to the left of the target."""
    return seen.left - seen.offset[:, None]


def _braking(action: Action, change: Callable[[Tensor], Tensor]) -> Action:
    """The action with its braking [m/s2] changed, its accelerating left alone."""
    wanted = action.acceleration
    return replace(action, acceleration=torch.where(wanted < 0, -change(-wanted), wanted))


def _looking_up(action: Action, seen: Observation) -> Action:
    away = (seen.step // 15) % 2 == 1
    return replace(action, acceleration=action.acceleration.masked_fill(away, 0.0))


_AHEAD = ("rear", "standing")
_CROSSING = ("crossing from the left", "crossing from the right")

FAULTS = {
    "blind_left": Mutation(
        "sees nobody whose middle is left of its path",
        lambda s: without(s, _beside(s) > 0.5),
        fails=("crossing from the left", "oncoming turn"),
    ),
    "blind_right": Mutation(
        "sees nobody whose middle is right of its path",
        lambda s: without(s, _beside(s) < -0.5),
        fails=("crossing from the right", "merge"),
    ),
    "short_sight": Mutation("sees 12 m far", lambda s: without(s, _gap(s) > 12.0), fails=_AHEAD),
    "late": Mutation("notices others 1.5 s before it would hit them", lambda s: without(s, _time_left(s) > 1.5), fails=_AHEAD),
    "ignores_merging": Mutation(
        "ignores who moves across its path",
        lambda s: without(s, s.speed_across.abs() > 0.3),
        fails=("cut-in", "merge", "oncoming turn", *_CROSSING),
    ),
    "ignores_standing": Mutation(
        "ignores who stands",
        lambda s: without(s, (s.speed_along.abs() < 0.5) & (s.speed_across.abs() < 0.5)),
        fails=("standing",),
    ),
    "ignores_rules": Mutation(
        "ignores signals, signs and right of way", lambda s: replace(s, rules=None), fails=("own turn", *_CROSSING)
    ),
    "cuts_gaps": Mutation(
        "takes gaps ahead for 8 m longer than they are", lambda s: replace(s, ahead=s.ahead + 8.0 * (s.ahead > 0)), fails=_AHEAD
    ),
    "misjudges_speeds": Mutation(
        "takes others for 5 m/s faster", lambda s: replace(s, speed_along=s.speed_along + 5.0), fails=_AHEAD
    ),
    "weak_brakes": Mutation("brakes by 1.5 m/s2 at most", do=lambda a, _: _braking(a, lambda b: b.clamp_max(1.5)), fails=_AHEAD),
    "slow_brakes": Mutation("brakes a third as hard as it means to", do=lambda a, _: _braking(a, lambda b: b / 3), fails=_AHEAD),
    "distracted": Mutation("looks away and rolls for 1.5 s out of every 3 s", do=_looking_up, fails=_AHEAD),
}


def _rows(seen: Observation) -> Tensor:
    """(S,) numbers of the targets."""
    return torch.arange(len(seen.speed), device=seen.speed.device)


def _others(seen: Observation) -> Tensor:
    """(M,) numbers of the others."""
    return torch.arange(seen.present.shape[1], device=seen.speed.device)


def _single(action: Action, seen: Observation) -> Action:
    return replace(action, acceleration=action.acceleration.to(seen.speed.dtype))


def _padded(seen: Observation) -> Observation:
    twice = of_others(seen, _others(seen).repeat(2))
    return without(twice, (_others(twice) >= seen.present.shape[1]).expand_as(twice.present))


_REVERSED = Mutation("takes the others in reverse order", lambda s: of_others(s, _others(s).flip(0)))
_PADDED = Mutation("has as many empty boxes again", _padded)
_OTHER_ROWS = Mutation(
    "decides for the targets in reverse order",
    lambda s: of_rows(s, _rows(s).flip(0)),
    lambda a, _: replace(a, acceleration=a.acceleration.flip(0)),
)

EQUIVALENTS = {
    "idm": {
        "mirrored": Mutation("has left and right exchanged", mirrored),
        "double": Mutation("reckons in double precision", in_double_precision, _single),
        "doubled": Mutation("has everybody twice", lambda s: of_others(s, _others(s).repeat(2))),
        "ahead_only": Mutation("leaves out who is behind", lambda s: replace(s, present=s.present & (s.ahead > 0))),
    },
    "gail": {"reversed": _REVERSED, "padded": _PADDED},
    "sac": {"reversed": _REVERSED, "other_rows": _OTHER_ROWS},
}
"""By the driver whose equals they are: what one of them never looks at, another one may."""

FAULTY = {
    base: [fault for number, fault in enumerate(FAULTS) if number % len(EQUIVALENTS) != skipped]
    for skipped, base in enumerate(EQUIVALENTS)
}
"""Eight faults of each driver: every fault is that of two drivers of three."""

MUTATIONS = {f"{base}.{fault}": FAULTS[fault] for base, faults in FAULTY.items() for fault in faults} | {
    f"{base}.{name}": mutation for base, equal in EQUIVALENTS.items() for name, mutation in equal.items()
}
"""Every mutated driver by its name, `<sound driver>.<mutation>`."""


class Mutant:
    """A sound driver with one mutation; `name` is one of MUTATIONS, else UnusableInput is raised. It has no settings."""

    settings_type: ClassVar[type] = type(None)

    def __init__(self, name: str, sound: Driver) -> None:
        if name not in MUTATIONS:
            of_it = [mutant for mutant in MUTATIONS if mutant.partition(".")[0] == name.partition(".")[0]]
            raise UnusableInput(f"there is no mutated driver {name!r}: there are {', '.join(of_it)}")
        self.name, self.sound = name, sound

    @property
    def sees_rules(self) -> bool:
        """Whether the sound one does."""
        return isinstance(self.sound, RuleDriver) and self.sound.sees_rules

    def act(self, observation: Observation) -> Action:
        """See `base.Driver`."""
        mutation = MUTATIONS[self.name]
        return mutation.do(self.sound.act(mutation.see(observation)), observation)


def mutated(sound: Mapping[str, Driver]) -> dict[str, Mutant]:
    """Every mutated driver of these, by its name."""
    bases = {name: name.partition(".")[0] for name in MUTATIONS}
    return {name: Mutant(name, sound[base]) for name, base in bases.items() if base in sound}
