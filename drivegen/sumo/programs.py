"""Traffic light programs of a SUMO network: what each link shows at any time, without running SUMO."""

from collections.abc import Iterable
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.signals import SignalState

_SHOWN = {
    **dict.fromkeys("gG", SignalState.GREEN),
    **dict.fromkeys("yY", SignalState.YELLOW),
    **dict.fromkeys("ru", SignalState.RED),
}
"""SUMO's letters; off (o, O) and the arrow that asks for a stop first (s) are UNKNOWN."""


@dataclass(frozen=True)
class Program:
    """A fixed-time program; actuated ones are read as if they kept their default durations.

    Attributes:
        until: (P,) float64 [s] end of each phase since the cycle's begin; the last one is the cycle time.
        shown: (P, K) uint8 SignalState of each of the K links.
        offset: [s] when the cycle begins, from the simulation's begin.
    """

    until: NDArray[np.float64]
    shown: NDArray[np.uint8]
    offset: float

    def at(self, time: NDArray[np.float64]) -> NDArray[np.uint8]:
        """SignalState (K, T) at the times (T,) [s]."""
        cycle = float(self.until[-1])
        phase = np.searchsorted(self.until, (time - self.offset) % cycle, side="right")
        return np.ascontiguousarray(self.shown[np.minimum(phase, len(self.until) - 1)].T)


def decode(letters: Iterable[str]) -> NDArray[np.uint8]:
    """SignalState (P, K) of P strings with one letter per link; shorter ones are UNKNOWN at their end."""
    rows = list(letters)
    table = np.zeros((len(rows), max(map(len, rows), default=0)), np.uint8)
    for row, word in zip(table, rows, strict=True):
        row[: len(word)] = [_SHOWN.get(letter, SignalState.UNKNOWN) for letter in word]
    return table


def read_programs(root: Element, place: str) -> dict[str, Program]:
    """The program of every traffic light in the network, by the light's id: of several the last, as in SUMO."""
    programs: dict[str, Program] = {}
    for logic in root.iterfind("tlLogic"):
        name = logic.get("id", "")
        phases = logic.findall("phase")
        try:
            durations = np.array([float(phase.get("duration", "nan")) for phase in phases])
            offset = float(logic.get("offset", "0"))
        except ValueError:  # offset="begin" is the only word that SUMO knows; durations are always numbers
            raise UnusableInput(f"{place}: traffic light {name!r} has a time that is not a number", reason="bad-map") from None
        if not len(phases) or not np.isfinite([*durations, offset]).all() or (durations < 0).any() or not durations.sum() > 0:
            raise UnusableInput(f"{place}: traffic light {name!r} has no phases that last", reason="bad-map")
        shown = decode(phase.get("state", "") for phase in phases)
        programs[name] = Program(np.cumsum(durations), shown, offset)
    return programs
