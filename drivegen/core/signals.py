"""Traffic signals of a scenario: which lanes they guard and what they show, step by step."""

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput


class SignalState(IntEnum):
    """State of a signal at one step, for the lane that it guards."""

    UNKNOWN = 0
    GREEN = 1
    YELLOW = 2
    RED = 3


@dataclass(frozen=True)
class Signals:
    """Traffic signals M_d: signal g guards the entry into lane `lane[g]`.

    Attributes:
        lane: (G,) int32 index into the map's lanes.
        state: (G, T) uint8 SignalState.
    """

    lane: NDArray[np.int32]
    state: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.lane)

    def validate(self, lanes: int) -> None:
        """Raise UnusableInput unless they guard some of so many lanes and their states are among `SignalState`."""
        if self.lane.size and not 0 <= self.lane.min() <= self.lane.max() < lanes:
            raise UnusableInput("a signal guards a lane that the map does not hold", reason="bad-signals")
        if (self.state > max(SignalState)).any():
            raise UnusableInput("a signal has a state that is none", reason="bad-signals")
        if len(np.unique(self.lane)) != len(self.lane):
            raise UnusableInput("two signals guard one lane", reason="bad-signals")

    @cached_property
    def closed(self) -> NDArray[np.bool_]:
        """(G, T) whether it is red or yellow."""
        return np.asarray((self.state == SignalState.RED) | (self.state == SignalState.YELLOW))

    @cached_property
    def shown(self) -> NDArray[np.bool_]:
        """(G,) whether it is ever known."""
        return np.asarray((self.state != SignalState.UNKNOWN).any(1))

    def held(self) -> "Signals":
        """The same, each signal showing its last known state wherever the state is UNKNOWN: what drivers assume."""
        last_shown = np.where(self.state != SignalState.UNKNOWN, np.arange(self.state.shape[1]), 0)
        return Signals(self.lane, np.take_along_axis(self.state, np.maximum.accumulate(last_shown, axis=1), axis=1))

    def on_lanes(self, lanes: NDArray[np.integer]) -> "Signals":
        """The signals of the lanes `lanes` (K,) only, which are numbered 0..K-1 from now on."""
        number = {lane: i for i, lane in enumerate(lanes.tolist())}
        inside = np.array([g for g, lane in enumerate(self.lane.tolist()) if lane in number], np.intp)
        return Signals(np.array([number[lane] for lane in self.lane[inside].tolist()], np.int32), self.state[inside])

    def of_lane(self, lane: int) -> NDArray[np.uint8]:
        """(T,) state of the signal of a lane, UNKNOWN where there is none."""
        states = self.state[self.lane == lane]
        return states[0] if len(states) else np.zeros(self.state.shape[1], np.uint8)

    @classmethod
    def none(cls, steps: int) -> "Signals":
        """No signals over `steps` steps."""
        return cls(np.zeros(0, np.int32), np.zeros((0, steps), np.uint8))
