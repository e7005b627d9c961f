"""Whether a corner case holds when the others react: the driver drives it again among neighbours of several kinds."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.corner_cases.case import Case
from drivegen.drivers.base import Driver
from drivegen.simulators.batch import Plugin, looks
from drivegen.world.reactive import Reaction
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes

CHUNK = 16
"""Cases that are driven together, padded to that: shapes stay the same, so do bytes."""


class Reacting(StrEnum):
    """Who reacts, and to whom."""

    NOBODY = "nobody"
    TO_EGO = "all, to the ego alone"
    BUT_ATTACKER = "all but the attacker"
    ALL = "all"


ATTENTION = {"attentive": (0.4, 8.0), "ordinary": (0.75, 6.0), "slow": (1.5, 4.0)}
"""Delay [s] and hardest braking [m/s2] of neighbours; `ordinary` is what `drive.reaction` has."""


def attentions(law: Reaction) -> dict[str, Reaction]:
    """The `law` with each delay and braking of ATTENTION."""
    return {name: replace(law, delay=delay, braking=braking) for name, (delay, braking) in ATTENTION.items()}


def holds(cases: Sequence[Case], driver: Driver, reacting: Reacting, law: Reaction) -> NDArray[np.bool_]:
    """(C,) whether each case, driven by `driver` among others who react by `law`, ends in a counted collision."""
    parts = [_holds(cases[first : first + CHUNK], driver, reacting, law) for first in range(0, len(cases), CHUNK)]
    return np.concatenate(parts) if parts else np.zeros(0, np.bool_)


def survival(
    cases: Sequence[Case], driver: Driver, laws: Mapping[str, Reaction]
) -> dict[tuple[str, Reacting], NDArray[np.bool_]]:
    """(C,) `holds` by the name of a law and by who reacts."""
    who = [kind for kind in Reacting if kind != Reacting.NOBODY]
    return {(name, kind): holds(cases, driver, kind, law) for name, law in laws.items() for kind in who}


def _holds(cases: Sequence[Case], driver: Driver, reacting: Reacting, law: Reaction) -> NDArray[np.bool_]:
    torch.set_num_threads(1)  # sums depend on the thread count
    scenarios, traffic = [case.scenario for case in cases], [case.traffic for case in cases]
    scenes = Scenes.of(scenarios, traffic, rows=CHUNK)
    lookout = Lookout.of(scenes, scenarios, traffic) if looks(driver) else None
    attacker = np.array([case.deaf if reacting == Reacting.BUT_ATTACKER else 0 for case in cases])
    simulator = Plugin(reaction=None if reacting == Reacting.NOBODY else law, to_target_alone=reacting == Reacting.TO_EGO)
    return simulator.drive(driver, scenes, scenarios, scenes.longest, attacker, lookout).counted
