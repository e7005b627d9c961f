"""An observation seen otherwise: some of the others left out, taken in another order, on another side."""

from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Any

import torch
from torch import Tensor

from drivegen.world.observation import Observation, Rules

OTHERS = ("ahead", "left", "half_length", "half_width", "speed_along", "speed_across", "present")
"""What an observation says of the others, (S, M) each."""


def without(seen: Observation, gone: Tensor) -> Observation:
    """Of the others those not seen who are `gone` (S, M), nor whether they have right of way."""
    rules = seen.rules and replace(seen.rules, arrives=seen.rules.arrives.masked_fill(gone, torch.inf))
    return replace(seen, present=seen.present & ~gone, rules=rules)


def of_others(seen: Observation, index: Tensor) -> Observation:
    """The others `index` (K,) in their order; one may come twice."""
    rules = seen.rules and replace(seen.rules, arrives=seen.rules.arrives[:, index])
    return replace(seen, rules=rules, **{name: getattr(seen, name)[:, index] for name in OTHERS})


def of_rows(seen: Observation, index: Tensor) -> Observation:
    """The targets `index` (R,) in their order."""
    rules = seen.rules and Rules(*_taken(seen.rules, index))
    own = [name for name in _names(seen) if name not in ("paths", "rules")]
    return replace(seen, paths=seen.paths[index], rules=rules, **{name: getattr(seen, name)[index] for name in own})


def mirrored(seen: Observation) -> Observation:
    """Left and right of the path exchanged; the path itself, on which nobody decides by the side, stays."""
    return replace(seen, offset=-seen.offset, course=-seen.course, left=-seen.left, speed_across=-seen.speed_across)


def in_double_precision(seen: Observation) -> Observation:
    """All numbers of the targets and the others as float64."""
    numbers: dict[str, Any] = {
        name: getattr(seen, name) for name in _names(seen) if name not in ("paths", "rules", "present", "step")
    }
    return replace(seen, **{name: value.double() for name, value in numbers.items()})


def _names(row: Observation) -> Iterable[str]:
    return (field.name for field in fields(row))


def _taken(rules: Rules, index: Tensor) -> list[Tensor]:
    return [getattr(rules, field.name)[index] for field in fields(rules)]
