"""Who is where, for generators that drive in closed loop: logs to learn from, and copies of a scene that are driven on.

Scenes are lists of boxes, one after the other: first the vehicles, which are planned, then the context actors, which are
replayed. Everything is a flat array over all boxes of all scenes, so cost doesn't depend on the widest scene of a batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import unit
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.store.columns import Starts, joined


@dataclass(frozen=True)
class Crowd:
    """All boxes of G groups at one instant each.

    Attributes:
        start: (G + 1,) int64 first box of each group, X at the end. scene, step: (G,) the map that each is on, and the instant.
        state: (X, 5) float32 x, y [m], heading [rad], velocity x, y [m/s] in the map's frame.
        there: (X,) bool seen at that instant. planned: (X,) bool a vehicle, not a context actor.
        size: (X, 2) float32 length, width [m]. kind: (X,) uint8 VehicleKind.
    """

    start: NDArray[np.int64]
    scene: NDArray[np.integer]
    step: NDArray[np.integer]
    state: NDArray[np.float32]
    there: NDArray[np.bool_]
    planned: NDArray[np.bool_]
    size: NDArray[np.float32]
    kind: NDArray[np.uint8]

    def group(self, box: NDArray[np.integer]) -> NDArray[np.int64]:
        """The group of each of `box` (R,)."""
        return np.asarray(np.searchsorted(self.start, box, side="right") - 1)


@dataclass(frozen=True)
class Tracks:
    """Motion of all boxes of S scenes; T is that of the longest, shorter ones end invalid.

    Attributes:
        start: (S + 1,) int64 first box of each scene, X at the end. planned: (X,) bool.
        size: (X, 2) float32 [m]. kind: (X,) uint8 VehicleKind.
        position, velocity: (X, T, 2) float32 [m], [m/s]; heading: (X, T) float32 [rad]; valid: (X, T) bool.
    """

    start: Annotated[NDArray[np.int64], Starts("planned")]
    planned: NDArray[np.bool_]
    size: NDArray[np.float32]
    kind: NDArray[np.uint8]
    position: NDArray[np.float32]
    velocity: NDArray[np.float32]
    heading: NDArray[np.float32]
    valid: NDArray[np.bool_]

    @classmethod
    def of_logs(cls, scenarios: Sequence[Scenario]) -> Self:
        """The logs of scenarios that have one."""
        return joined(cls, [cls._of(s, s.log) for s in scenarios if s.log is not None])

    @classmethod
    def of_beginnings(cls, scenarios: Sequence[Scenario], copies: int) -> Self:
        """`copies` copies of each scenario side by side; of the vehicles there is the first frame, nothing else."""
        return joined(cls, [one for s in scenarios for one in [cls._of(s, _beginning(s))] * copies])

    @classmethod
    def _of(cls, scenario: Scenario, motion: Trajectories) -> Self:
        """One scene, in which the vehicles move like that."""
        vehicles, actors = scenario.vehicles, scenario.context
        size, kind = np.concatenate([vehicles.size, actors.size]), np.concatenate([vehicles.kind, actors.kind])
        every, planned = Trajectories.joined([motion, actors.motion]), np.arange(len(kind)) < len(vehicles)
        start = np.array([0, len(kind)])
        return cls(start, planned, size[:, :2], kind, every.position, every.velocity, every.heading, every.valid)

    @classmethod
    def none(cls) -> Self:
        """No scene."""
        still, size, kind = Trajectories.empty(0, 1), np.zeros((0, 2), np.float32), np.zeros(0, np.uint8)
        start, planned = np.zeros(1, np.int64), np.zeros(0, np.bool_)
        return cls(start, planned, size, kind, still.position, still.velocity, still.heading, still.valid)

    def scene(self, box: NDArray[np.integer]) -> NDArray[np.int64]:
        """The scene of each of `box` (R,)."""
        return np.asarray(np.searchsorted(self.start, box, side="right") - 1)

    def boxes(self, scene: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The boxes of each of `scene` (G,) one after the other (X,), and the first of each (G + 1,), X at the end."""
        count = np.diff(self.start)[scene]
        start = np.concatenate([[0], np.cumsum(count)])
        return start, np.arange(start[-1]) + np.repeat(self.start[scene] - start[:-1], count)

    def at(self, scene: NDArray[np.integer], step: NDArray[np.integer], copies: int = 1) -> Crowd:
        """The boxes of each of `scene` (G,) at its `step` (G,); `copies` of them are on each map."""
        start, box = self.boxes(scene)
        when = np.repeat(step, np.diff(start))
        columns = (self.position[box, when], self.heading[box, when, None], self.velocity[box, when])
        state, there = np.concatenate(columns, axis=1), self.valid[box, when]
        return Crowd(start, scene // copies, step, state, there, self.planned[box], self.size[box], self.kind[box])

    def drive(self, box: NDArray[np.integer], step: int, motion: Trajectories) -> None:
        """Write how `box` (R,) go on after `step`: motion (R, C), cut off where the scenes end."""
        count = min(motion.steps, self.valid.shape[1] - 1 - step)
        part = slice(step + 1, step + 1 + count)
        for name in ("position", "velocity", "heading"):
            getattr(self, name)[box, part] = getattr(motion, name)[:, :count]
        self.valid[box, part] = True

    def samples(self, scenarios: Sequence[Scenario], copies: int, method: str) -> list[Samples]:
        """What was driven, scenario by scenario."""
        made = []
        for number, scenario in enumerate(scenarios):
            first = self.start[number * copies : (number + 1) * copies]
            box = first[:, None] + np.arange(len(scenario.vehicles))
            motion = Trajectories(self.position[box], self.heading[box], self.velocity[box], self.valid[box])
            made.append(Samples.without_goals(scenario.scenario_id, method, motion.until(scenario.steps)))
        return made


def _beginning(scenario: Scenario) -> Trajectories:
    """Initial states as motion (N, T) of which step 0 alone is valid."""
    vehicles = scenario.vehicles
    motion = Trajectories.empty(len(vehicles), scenario.steps)
    motion.position[:, 0], motion.heading[:, 0], motion.valid[:, 0] = vehicles.position, vehicles.heading, True
    motion.velocity[:, 0] = unit(vehicles.heading) * vehicles.speed[:, None]
    return motion
