"""What a traffic scenario is: S = {M_s, P, T} (paper, problem formulation), as structs of arrays.

M_s is a `RoadMap`, P are `Vehicles`, T are `Trajectories`; signals M_d and people on foot or bicycle (`Actors`) come
with it. Vehicle 0 is the target, the others are social vehicles in asset order. Everything is in the map's local
frame, metres, seconds, radians, at 10 Hz; step 0 is the first frame.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput, naming
from drivegen.core.roadmap import RoadMap
from drivegen.core.signals import Signals

DT = 0.1
"""Time between steps [s]."""

FIRST_SECOND = 10
"""What happens up to this step is no driver's doing, but that of what the traffic began with."""

TARGET = 0
"""Index of the target vehicle in every scenario."""

SPLITS = ("train", "val", "test")
"""Parts of a data set, each in a folder of that name."""

SAFE_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,199}")
"""Ids of scenarios name files and folders."""


class VehicleKind(IntEnum):
    """Kinds of vehicles and of context actors."""

    CAR = 0
    TRUCK = 1
    BUS = 2
    MOTORCYCLE = 3
    CYCLIST = 4
    PEDESTRIAN = 5


class SizeSource(IntEnum):
    """Where a box size comes from: every collision figure depends on it."""

    MEASURED = 0
    ASSUMED = 1
    SHRUNK = 2


@dataclass(frozen=True)
class Trajectories:
    """Motion of boxes' centres; leading dimensions are free: (N, T) a log, (K, N, T) samples.

    Attributes:
        position: (..., T, 2) float32 [m].
        heading: (..., T) float32 [rad].
        velocity: (..., T, 2) float32 [m/s] in the map's frame, not the vehicle's.
        valid: (..., T) bool, whether the step was observed or generated; elsewhere the numbers mean nothing.
    """

    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    velocity: NDArray[np.float32]
    valid: NDArray[np.bool_]

    @property
    def speed(self) -> NDArray[np.float32]:
        """(..., T) [m/s]."""
        return np.hypot(self.velocity[..., 0], self.velocity[..., 1])

    @property
    def steps(self) -> int:
        """T, the first frame included."""
        return int(self.valid.shape[-1])

    def __getitem__(self, index: Any) -> "Trajectories":
        """Index the leading dimensions (never time), as in `samples[k]` or `log[keep]`."""
        return Trajectories(self.position[index], self.heading[index], self.velocity[index], self.valid[index])

    def put(self, index: Any, motion: "Trajectories") -> None:
        """Overwrite what `index` chooses of the leading dimensions, in place."""
        for f in fields(self):
            getattr(self, f.name)[index] = getattr(motion, f.name)

    def copy(self) -> "Trajectories":
        """The same in arrays of its own."""
        return Trajectories(*(getattr(self, f.name).copy() for f in fields(self)))

    def until(self, steps: int) -> "Trajectories":
        """The first `steps` steps."""
        return self.between(0, steps)

    def between(self, first: int, last: int) -> "Trajectories":
        """Steps `first` to `last`, the latter not included."""
        return Trajectories(
            self.position[..., first:last, :],
            self.heading[..., first:last],
            self.velocity[..., first:last, :],
            self.valid[..., first:last],
        )

    def padded(self, steps: int) -> "Trajectories":
        """A copy of `steps` steps, at least its own, after which it is not valid."""
        whole = Trajectories.empty(*self.valid.shape[:-1], steps)
        for f in fields(self):
            array = getattr(self, f.name)
            getattr(whole, f.name)[tuple(map(slice, array.shape))] = array
        return whole

    def last_valid(self) -> NDArray[np.intp]:
        """(...) index of the last valid step; 0 where none is."""
        return np.where(self.valid.any(-1), self.steps - 1 - np.argmax(self.valid[..., ::-1], axis=-1), 0)

    def stretches(self) -> list[NDArray[np.float32]]:
        """Positions (P, 2) [m] of one track (T,), apart for each run of valid steps: nobody saw what lies between two."""
        edges = np.flatnonzero(np.diff(self.valid, prepend=False, append=False)).reshape(-1, 2)
        return [self.position[first:last] for first, last in edges.tolist()]

    def standing_after_end(self, seen: NDArray[np.bool_] | None = None) -> "Trajectories":
        """A copy in which every track stands still after its last step in `seen` (..., T), by default its last valid one.

        `valid` does not change, nor does a track without any such step.
        """
        seen = self.valid if seen is None else seen
        steps = np.arange(self.steps)
        last = np.where(seen.any(-1), self.steps - 1 - np.argmax(seen[..., ::-1], axis=-1), self.steps - 1)[..., None]
        at = np.minimum(steps, last)
        return Trajectories(
            np.take_along_axis(self.position, at[..., None], axis=-2),
            np.take_along_axis(self.heading, at, axis=-1),
            np.where((steps > last)[..., None], np.float32(0), self.velocity),
            self.valid,
        )

    @classmethod
    def empty(cls, *shape: int) -> "Trajectories":
        """Nothing valid, all zero, of shape (..., T)."""
        pair = np.zeros((*shape, 2), np.float32)
        return cls(pair, np.zeros(shape, np.float32), pair.copy(), np.zeros(shape, np.bool_))

    @classmethod
    def joined(cls, parts: "Sequence[Trajectories]") -> "Trajectories":
        """All parts (N_i, ..., T_i), one after the other along the first dimension; the shorter ones are padded."""
        steps = max(part.steps for part in parts)
        whole = [part if part.steps == steps else part.padded(steps) for part in parts]
        return cls(*(np.concatenate([getattr(part, f.name) for part in whole]) for f in fields(cls)))

    @property
    def finite(self) -> bool:
        """Whether all numbers at valid steps are finite."""
        return all(bool(np.isfinite(a[self.valid]).all()) for a in (self.position, self.heading, self.velocity))

    def validate(self) -> None:
        """Raise UnusableInput unless shapes agree and all valid numbers are finite."""
        shape = self.valid.shape
        if self.heading.shape != shape or self.position.shape != (*shape, 2) or self.velocity.shape != (*shape, 2):
            raise UnusableInput("trajectory arrays differ in shape", reason="bad-trajectories")
        if not self.finite:
            raise UnusableInput("a trajectory has positions that are not numbers", reason="not-a-number")


def _expect_kinds_and_sizes(kind: NDArray[np.uint8], size: NDArray[np.float32]) -> None:
    if (kind > max(VehicleKind)).any():
        raise UnusableInput(f"a vehicle is of kind {kind.max()}, which is none", reason="bad-vehicles")
    if not (np.isfinite(size) & (size > 0)).all():
        raise UnusableInput("a vehicle has a size that is no positive number", reason="bad-vehicles")


@dataclass(frozen=True)
class Vehicles:
    """Attributes P of N vehicles, the target first: kind, size and initial state.

    Attributes:
        track_id: (N,) str, the log's ids where there is a log.
        kind: (N,) uint8 VehicleKind.
        size: (N, 3) float32 length, width, height [m].
        size_source: (N,) uint8 SizeSource.
        position: (N, 2) float32 [m] of the box's centre at step 0.
        heading: (N,) float32 [rad].
        speed: (N,) float32 [m/s].
    """

    track_id: NDArray[np.str_]
    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    size_source: NDArray[np.uint8]
    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    speed: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.kind)

    def __getitem__(self, index: Any) -> "Vehicles":
        """The chosen vehicles, as in `vehicles[keep]`."""
        arrays = (self.track_id, self.kind, self.size, self.size_source, self.position, self.heading, self.speed)
        return Vehicles(*(a[index] for a in arrays))

    def validate(self) -> None:
        """Raise UnusableInput unless there is a vehicle, shapes agree and numbers make sense."""
        count = len(self)
        if count == 0:
            raise UnusableInput("the scenario has no vehicles", reason="no-vehicles")
        per_vehicle = (self.track_id, self.size_source, self.heading, self.speed)
        if self.size.shape != (count, 3) or self.position.shape != (count, 2) or any(a.shape != (count,) for a in per_vehicle):
            raise UnusableInput("vehicle arrays differ in length", reason="bad-vehicles")
        if not all(np.isfinite(a).all() for a in (self.size, self.position, self.heading, self.speed)):
            raise UnusableInput("a vehicle has an initial state that is not a number", reason="not-a-number")
        _expect_kinds_and_sizes(self.kind, self.size)


@dataclass(frozen=True)
class Actors:
    """A context actors (pedestrians, cyclists, motorcyclists): replayed as logged, avoided, never planned.

    Attributes:
        track_id: (A,) str. kind: (A,) uint8 VehicleKind. size: (A, 3) float32 [m].
        motion: Trajectories of shape (A, T).
    """

    track_id: NDArray[np.str_]
    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    motion: Trajectories

    def __len__(self) -> int:
        return len(self.kind)

    def validate(self) -> None:
        """Raise UnusableInput unless shapes agree and numbers make sense."""
        count = len(self)
        if self.size.shape != (count, 3) or self.track_id.shape != (count,) or len(self.motion.valid) != count:
            raise UnusableInput("the arrays of context actors differ in length", reason="bad-vehicles")
        _expect_kinds_and_sizes(self.kind, self.size)
        self.motion.validate()

    @classmethod
    def none(cls, steps: int) -> "Actors":
        """No context actors over `steps` steps."""
        return cls(np.zeros(0, np.str_), np.zeros(0, np.uint8), np.zeros((0, 3), np.float32), Trajectories.empty(0, steps))


@dataclass(frozen=True)
class Present:
    """M vehicles and context actors at one moment, the vehicles first.

    Attributes:
        kind: (M,) uint8 VehicleKind. size: (M, 3) float32 [m].
        position: (M, 2) float32 [m]. heading: (M,) float32 [rad]. speed: (M,) float32 [m/s].
    """

    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    speed: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.kind)


@dataclass(frozen=True)
class Scenario:
    """One scenario: where (map), who (vehicles), what happened (log, if it was recorded).

    Attributes:
        scenario_id: unique within its data set.
        source: data set and provenance in words, e.g. "Argoverse 2 Motion Forecasting" or "SUMO corpus (simulated)".
        city: city or network name; map splits are disjoint by it.
        map: RoadMap.
        vehicles: (N,) the target first.
        horizon: number of steps after the first frame; T = horizon + 1.
        log: Trajectories (N, T) as recorded, or None for a new scenario.
        context: Actors over the same T steps.
        signals: Signals over the same T steps.
        notes: what was adapted on the way in, counted in the report, e.g. {"target": "AV, focal track is no vehicle"}.
        per_hour: how often such a scenario occurs in an hour of the traffic that it was drawn from [1/h]; 0 where nobody knows.
    """

    scenario_id: str
    source: str
    city: str
    map: RoadMap
    vehicles: Vehicles
    horizon: int
    log: Trajectories | None
    context: Actors
    signals: Signals
    notes: dict[str, str] = field(default_factory=dict)
    per_hour: float = 0.0

    @property
    def steps(self) -> int:
        """T = horizon + 1."""
        return self.horizon + 1

    def present(self) -> Present:
        """Everybody at step 0: the vehicles, then the context actors that are there."""
        v, actors = self.vehicles, self.context
        here = np.flatnonzero(actors.motion.valid[:, 0])
        now = actors.motion[here, 0]
        return Present(
            np.concatenate([v.kind, actors.kind[here]]),
            np.concatenate([v.size, actors.size[here]]),
            np.concatenate([v.position, now.position]),
            np.concatenate([v.heading, now.heading]),
            np.concatenate([v.speed, now.speed]),
        )

    def validate(self) -> None:
        """Raise UnusableInput, naming the scenario, unless all parts are sound and agree with one another."""
        with naming(f"scenario {self.scenario_id}"):
            self._validate_parts()

    def _validate_parts(self) -> None:
        if self.horizon < 1:
            raise UnusableInput(f"its horizon is {self.horizon} steps", reason="bad-trajectories")
        self.map.validate()
        self.vehicles.validate()
        self.context.validate()
        self.signals.validate(len(self.map))
        if self.log is not None:
            self.log.validate()
            if self.log.valid.shape != (len(self.vehicles), self.steps):
                raise UnusableInput("log and vehicles differ in shape", reason="bad-trajectories")
        if self.context.motion.steps != self.steps or self.signals.state.shape != (len(self.signals), self.steps):
            raise UnusableInput("context or signals do not last as long as the scenario", reason="bad-trajectories")
