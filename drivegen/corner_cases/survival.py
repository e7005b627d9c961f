"""Whether a corner case holds when the others react: the driver drives it again among neighbours of several kinds."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Protocol

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.base import Driver
from drivegen.simulators.batch import Plugin, looks
from drivegen.world.outcome import DrivingOutcome
from drivegen.world.reactive import Reaction
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes

CHUNK = 16
"""Cases that are driven together, padded to that: shapes stay the same, so do bytes."""


class Repeatable(Protocol):
    """What can be driven again, such as a `Case`."""

    @property
    def scenario(self) -> Scenario:
        """Its map, first frame, people and signals; vehicle 0 is the target."""

    @property
    def traffic(self) -> Trajectories:
        """(N, T) how everybody is to move."""

    @property
    def deaf(self) -> int:
        """The vehicle that does not react where all but the attacker do."""


class Reacting(StrEnum):
    """Who reacts, and to whom."""

    NOBODY = "nobody"
    TO_EGO = "all, to the ego alone"
    BUT_ATTACKER = "all but the attacker"
    ALL = "all"


ATTENTION = {"attentive": (0.4, 8.0), "ordinary": None, "slow": (1.5, 4.0)}
"""Delay [s] and hardest braking [m/s2] of neighbours; ordinary ones have those of the law."""


def attentions(law: Reaction) -> dict[str, Reaction]:
    """The `law` with each delay and braking of ATTENTION."""
    return {name: law if at is None else replace(law, delay=at[0], braking=at[1]) for name, at in ATTENTION.items()}


def holds(cases: Sequence[Repeatable], driver: Driver, reacting: Reacting, law: Reaction) -> NDArray[np.bool_]:
    """(C,) whether each case, driven by `driver` among others who react by `law`, ends in a counted collision."""
    return np.concatenate([np.zeros(0, np.bool_), *(part.counted for part in _drives(cases, driver, reacting, law))])


def partners(cases: Sequence[Repeatable], driver: Driver, law: Reaction) -> NDArray[np.int32]:
    """(C,) whom the driver collides with where nobody reacts, as in `DrivingOutcome`."""
    return np.concatenate([np.zeros(0, np.int32), *(part.partner for part in _drives(cases, driver, Reacting.NOBODY, law))])


def survival(
    cases: Sequence[Repeatable], driver: Driver, laws: Mapping[str, Reaction]
) -> dict[tuple[str, Reacting], NDArray[np.bool_]]:
    """(C,) `holds` by the name of a law and by who reacts."""
    who = [kind for kind in Reacting if kind != Reacting.NOBODY]
    return {(name, kind): holds(cases, driver, kind, law) for name, law in laws.items() for kind in who}


def _drives(cases: Sequence[Repeatable], driver: Driver, reacting: Reacting, law: Reaction) -> Iterator[DrivingOutcome]:
    for first in range(0, len(cases), CHUNK):
        yield _drive(cases[first : first + CHUNK], driver, reacting, law)


def _drive(cases: Sequence[Repeatable], driver: Driver, reacting: Reacting, law: Reaction) -> DrivingOutcome:
    torch.set_num_threads(1)  # sums depend on the thread count
    scenarios, traffic = [case.scenario for case in cases], [case.traffic for case in cases]
    scenes = Scenes.of(scenarios, traffic, rows=CHUNK)
    lookout = Lookout.of(scenes, scenarios, traffic) if looks(driver) else None
    attacker = np.array([case.deaf if reacting == Reacting.BUT_ATTACKER else 0 for case in cases])
    simulator = Plugin(reaction=None if reacting == Reacting.NOBODY else law, to_target_alone=reacting == Reacting.TO_EGO)
    return simulator.drive(driver, scenes, scenarios, scenes.longest, attacker, lookout)
