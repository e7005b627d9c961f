"""Lean on the goals of social vehicles: from the probabilities that goals are drawn with to those used for corner cases.

Planned motion towards each candidate goal is met with the target's expected motion; candidates whose encounter looks
like past failures gain weight. The natural probability stays in the record beside the one used, so every corner case
carries its importance ratio.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import DT
from drivegen.core.settings import NotNegative, Positive, Within
from drivegen.corner_cases.encounters import Encounters
from drivegen.corner_cases.knowledge import Knowledge

FLOOR = 0.1
"""What is far away or too early has this share of the base rate for a risk, so that no goal becomes impossible."""

HALVINGS = 60
"""Of the interval in which `bounded` looks for its normaliser: no double could tell more."""


@dataclass(frozen=True)
class PressureSettings:
    """How hard to lean.

    Attributes:
        strength: exponent of the risk ratio; 0 leaves the selector alone. Large ones would make zeros of small ratios.
        reach: closest approaches beyond this gap [m] are no encounters.
        max_ratio: bound of the ratio of a goal's probability to that without pressure, and of its inverse.
        reaction_time: encounters earlier than this [s] gain nothing: the driver could not react.
    """

    strength: Annotated[float, Within(0, 20)]
    reach: Positive
    max_ratio: Annotated[float, Within(1)]
    reaction_time: NotNegative


def risk(met: Encounters, knowledge: Knowledge, settings: PressureSettings) -> NDArray[np.float64]:
    """Risk of each planned encounter: P(collision | features), fading to FLOOR of the base rate at `reach`."""
    cell = knowledge.probability()[met.speed_bin, met.direction, met.behaviour]
    nearness = np.where(met.met & ~met.behind, np.clip(1.0 - met.gap / settings.reach, 0.0, 1.0), 0.0)
    in_time = met.step * DT >= settings.reaction_time
    floor = FLOOR * knowledge.base_rate
    return floor + np.where(in_time, cell * nearness, 0.0)


def lean(natural: NDArray[np.floating], risks: NDArray[np.float64], settings: PressureSettings) -> NDArray[np.float32]:
    """Probabilities (C,) used for one vehicle's candidates: natural * risk ** strength, normalised and `bounded`."""
    return bounded(natural, (risks / risks.max()) ** settings.strength, settings.max_ratio)


def bounded(natural: NDArray[np.floating], tilt: NDArray[np.float64], bound: float) -> NDArray[np.float32]:
    """Probabilities (C,) natural * tilt, normalised, with every ratio to `natural` within `bound` and its inverse.

    `tilt` (C,) is positive. The normaliser is the root of a sum of clipped ratios, which grows with it from 1 / bound to
    bound and so crosses 1 once.
    """

    def ratio(log_scale: float) -> NDArray[np.float64]:
        return np.asarray(np.clip(tilt * np.exp(log_scale), 1 / bound, bound))

    low, high = np.log(1 / bound), np.log(bound / tilt.min())
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if (natural * ratio(middle)).sum() < natural.sum() else (low, middle)
    used = natural * ratio((low + high) / 2)
    return np.asarray(used / used.sum(), np.float32)
