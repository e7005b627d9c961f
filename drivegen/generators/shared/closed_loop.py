"""Who is where, for generators that drive in closed loop: logs to learn from, and copies of a scene that are driven on.

Scenes are lists of boxes, one after the other: first the vehicles, which are planned, then the context actors, which are
replayed. Everything is a flat array over all boxes of all scenes, so cost doesn't depend on the widest scene of a batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import unit
from drivegen.core.samples import Samples
from drivegen.core.scenario import Actors, Scenario, Trajectories, Vehicles
from drivegen.core.settings import expect_multiple
from drivegen.store.columns import Starts

_MOVING = ("position", "velocity", "heading", "valid")


@dataclass(frozen=True)
class Crowd:
    """All boxes of G groups at one instant each.

    Attributes:
        start: (G + 1,) int64 first box of each group, X at the end.
        state: (X, 5) float32 x, y [m], heading [rad], velocity x, y [m/s] in the map's frame.
        there: (X,) bool seen at that instant. planned: (X,) bool a vehicle, not a context actor.
        size: (X, 2) float32 length, width [m].
    """

    start: NDArray[np.int64]
    state: NDArray[np.float32]
    there: NDArray[np.bool_]
    planned: NDArray[np.bool_]
    size: NDArray[np.float32]


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
        return cls._of([(s.vehicles, s.log, s.context) for s in scenarios if s.log is not None])

    @classmethod
    def of_beginnings(cls, scenarios: Sequence[Scenario], copies: int) -> Self:
        """`copies` copies of each scenario side by side; of the vehicles there is the first frame, nothing else."""
        return cls._of([(s.vehicles, _beginning(s), s.context) for s in scenarios for _ in range(copies)])

    @classmethod
    def _of(cls, scenes: list[tuple[Vehicles, Trajectories, Actors]]) -> Self:
        counts = [(len(vehicles), len(actors)) for vehicles, _, actors in scenes]
        steps = max((motion.steps for _, motion, _ in scenes), default=1)
        start = np.cumsum([0, *(n + a for n, a in counts)])
        made = cls(
            start,
            np.zeros(start[-1], np.bool_),
            np.zeros((start[-1], 2), np.float32),
            np.zeros(start[-1], np.uint8),
            np.zeros((start[-1], steps, 2), np.float32),
            np.zeros((start[-1], steps, 2), np.float32),
            np.zeros((start[-1], steps), np.float32),
            np.zeros((start[-1], steps), np.bool_),
        )
        for row, (vehicles, motion, actors) in zip(start[:-1].tolist(), scenes, strict=True):
            made.planned[row : row + len(vehicles)] = True
            made._fill(row, vehicles, motion)
            made._fill(row + len(vehicles), actors, actors.motion)
        return made

    def _fill(self, row: int, boxes: Vehicles | Actors, motion: Trajectories) -> None:
        part = slice(row, row + len(boxes)), slice(0, motion.steps)
        self.size[part[0]], self.kind[part[0]] = boxes.size[:, :2], boxes.kind
        for name in _MOVING:
            getattr(self, name)[part] = getattr(motion, name)

    @classmethod
    def none(cls) -> Self:
        """No scene."""
        return cls._of([])

    def scene(self, box: NDArray[np.integer]) -> NDArray[np.int64]:
        """The scene of each of `box` (R,)."""
        return np.asarray(np.searchsorted(self.start, box, side="right") - 1)

    def boxes(self, scene: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The boxes of each of `scene` (G,) one after the other (X,), and the first of each (G + 1,), X at the end."""
        count = np.diff(self.start)[scene]
        start = np.concatenate([[0], np.cumsum(count)])
        return start, np.arange(start[-1]) + np.repeat(self.start[scene] - start[:-1], count)

    def at(self, scene: NDArray[np.integer], step: NDArray[np.integer]) -> Crowd:
        """The boxes of each of `scene` (G,) at its `step` (G,)."""
        start, box = self.boxes(scene)
        when = np.repeat(step, np.diff(start))
        columns = (self.position[box, when], self.heading[box, when, None], self.velocity[box, when])
        return Crowd(start, np.concatenate(columns, axis=1), self.valid[box, when], self.planned[box], self.size[box])

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


def expect_commits(place: str, horizon: int, commit: int, every: int) -> None:
    """Raise UnusableInput unless `commit` is at most `horizon`, and both settings of `place` are multiples of `every`."""
    for name, steps in (("horizon", horizon), ("commit", commit)):
        expect_multiple(f"{place}.{name}", steps, every)
    if commit > horizon:
        raise UnusableInput(f"{place}.commit must be at most horizon, {horizon}, not {commit}")


def _beginning(scenario: Scenario) -> Trajectories:
    """Initial states as motion (N, T) of which step 0 alone is valid."""
    vehicles = scenario.vehicles
    motion = Trajectories.empty(len(vehicles), scenario.steps)
    motion.position[:, 0], motion.heading[:, 0], motion.valid[:, 0] = vehicles.position, vehicles.heading, True
    motion.velocity[:, 0] = unit(vehicles.heading) * vehicles.speed[:, None]
    return motion
