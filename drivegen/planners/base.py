"""The protocol of a planner: learn from logs, then fill in motion between initial states and goals, in batches."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.training.curve import LossRow

ROUTE_SPACING = 1.0
"""Distance between points of a route line [m]."""

ROUTE_POINTS = 448
"""P, points of every padded route line: 40 m/s for 11 s; fixed, so that a result does not depend on its batch.

A path goes straight on beyond them.
"""

PARKED_SPEED = 0.3
"""[m/s] A vehicle slower than this, with a goal nearer than PARKED_GOAL, stays exactly where it is."""

PARKED_GOAL = 1.0
"""[m]."""


@dataclass(frozen=True)
class PlanRequests:
    """B trajectories that are wanted, from many scenarios at once.

    Requests refer to routes and to vehicles by index, so ten samples of one vehicle share one context.

    Attributes:
        scenario: (B,) int32 which scenario of the batch. vehicle: (B,) int32 which vehicle of it.
        position: (B, 2) float32 [m], heading: (B,) [rad], speed: (B,) [m/s], size: (B, 3) [m]: the state at step 0.
        goal_position: (B, 2), goal_heading: (B,), goal_speed: (B,): the state at the goal step; met exactly by who
            moves, but for planner `paper`, which approaches it.
        goal_step: (B,) int32 the step of the goal: the scenario's last, or a logged track's last valid one.
        route: (B,) int32 row of `route_line`, or -1 where no route fits (parking, leaving the map).
        route_line: (R, ROUTE_POINTS, 2) float32 [m] points every ROUTE_SPACING, the line starts abreast of its vehicle
            (s = 0).
        route_length: (R,) float32 [m] valid length of each line; points beyond it go straight on.
        route_speed_limit: (R, ROUTE_POINTS) float32 [m/s], NaN unknown.
        goal_s, goal_d: (B,) float32 [m] the goal along and left of its route; 0 where there is none.
        leader_gap: (B,) float32 [m] bumper to bumper to the next vehicle ahead on the route at step 0, inf if none.
        leader_speed: (B,) float32 [m/s], 0 where there is none.
        stop_s: (B,) float32 [m] distance along the route to the next red or yellow signal at step 0, inf if none.
        seed: (B,) int64; a result depends on its request and this number alone, never on its neighbours in the batch.
    """

    scenario: NDArray[np.int32]
    vehicle: NDArray[np.int32]
    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    speed: NDArray[np.float32]
    size: NDArray[np.float32]
    goal_position: NDArray[np.float32]
    goal_heading: NDArray[np.float32]
    goal_speed: NDArray[np.float32]
    goal_step: NDArray[np.int32]
    route: NDArray[np.int32]
    route_line: NDArray[np.float32]
    route_length: NDArray[np.float32]
    route_speed_limit: NDArray[np.float32]
    goal_s: NDArray[np.float32]
    goal_d: NDArray[np.float32]
    leader_gap: NDArray[np.float32]
    leader_speed: NDArray[np.float32]
    stop_s: NDArray[np.float32]
    seed: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.seed)

    def __getitem__(self, index: Any) -> "PlanRequests":
        """The chosen requests, as in `requests[keep]`; the route table stays whole."""
        chosen = {f.name: getattr(self, f.name)[index] for f in fields(self) if f.name not in _ROUTE_TABLE}
        return replace(self, **chosen)

    @classmethod
    def join(cls, parts: "Sequence[PlanRequests]", scenarios: Sequence[int]) -> "PlanRequests":
        """All parts in order; part k speaks of `scenarios[k]` scenarios of its own, which are numbered on."""
        first_scenario = np.cumsum([0, *scenarios])
        first_route = np.cumsum([0, *(len(p.route_length) for p in parts)])
        moved = [
            replace(
                part,
                scenario=part.scenario + np.int32(first_scenario[k]),
                route=np.where(part.route >= 0, part.route + np.int32(first_route[k]), part.route),
            )
            for k, part in enumerate(parts)
        ]
        whole = [cls.none(), *moved]
        return cls(**{f.name: np.concatenate([getattr(part, f.name) for part in whole]) for f in fields(cls)})

    @classmethod
    def none(cls) -> "PlanRequests":
        """No request at all."""
        number, count, point = np.zeros(0, np.float32), np.zeros(0, np.int32), np.zeros((0, 2), np.float32)
        return cls(
            scenario=count, vehicle=count, position=point, heading=number, speed=number, size=np.zeros((0, 3), np.float32),
            goal_position=point, goal_heading=number, goal_speed=number, goal_step=count, route=count,
            route_line=np.zeros((0, ROUTE_POINTS, 2), np.float32), route_length=number,
            route_speed_limit=np.zeros((0, ROUTE_POINTS), np.float32), goal_s=number, goal_d=number, leader_gap=number,
            leader_speed=number, stop_s=number, seed=np.zeros(0, np.int64),
        )  # fmt: skip

    @property
    def parked(self) -> NDArray[np.bool_]:
        """(B,) vehicles that stand and are to stay: they are not planned but left exactly where they are."""
        away = np.hypot(*(self.goal_position - self.position).T)
        return np.asarray((self.speed < PARKED_SPEED) & (away < PARKED_GOAL))


_ROUTE_TABLE = {"route_line", "route_length", "route_speed_limit"}


@dataclass(frozen=True)
class Examples:
    """What a planner learns from: logged tracks as requests for their own end state, and how they really drove.

    Attributes:
        scenarios: the scenarios that `PlanRequests.scenario` counts through.
        requests: PlanRequests of B tracks.
        motion: Trajectories (B, T), with gaps where the log has them.
    """

    scenarios: Sequence[Scenario]
    requests: PlanRequests
    motion: Trajectories

    def __len__(self) -> int:
        return len(self.requests)

    def __getitem__(self, index: Any) -> "Examples":
        """The chosen tracks."""
        return Examples(self.scenarios, self.requests[index], self.motion[index])

    @classmethod
    def join(cls, parts: "Sequence[Examples]") -> "Examples":
        """All parts in order, of one or of different lengths in time."""
        scenarios = [s for part in parts for s in part.scenarios]
        steps = max((part.motion.steps for part in parts), default=1)
        motion = Trajectories.empty(sum(map(len, parts)), steps)
        low = 0
        for part in parts:
            rows = slice(low, low + len(part))
            motion.position[rows, : part.motion.steps] = part.motion.position
            motion.heading[rows, : part.motion.steps] = part.motion.heading
            motion.velocity[rows, : part.motion.steps] = part.motion.velocity
            motion.valid[rows, : part.motion.steps] = part.motion.valid
            low += len(part)
        return cls(scenarios, PlanRequests.join([p.requests for p in parts], [len(p.scenarios) for p in parts]), motion)


@dataclass
class Stream:
    """Examples that come in parts and are gone through once; `tracks` have come so far."""

    parts: Iterator[Examples]
    tracks: int = 0

    def __iter__(self) -> Iterator[Examples]:
        for part in self.parts:
            self.tracks += len(part)
            yield part


class Planner(Protocol):
    """`Plugin(settings)` is an untrained planner; `Plugin.Settings` is the dataclass of its params section.

    Attributes:
        Settings: frozen dataclass without defaults; its values stand in `params.yaml`, `train_planner.planners.<name>`.
        learnt_from: how many examples batches were drawn from in `fit`, 0 before: tracks, or scenes where a batch is of scenes.
    """

    Settings: type
    learnt_from: int

    def __init__(self, settings: Any) -> None:
        """An untrained planner."""

    def fit(
        self,
        train: Iterable[Examples],
        validation: Examples,
        seed: int,
        checkpoints: Path | None,
        report: Callable[[str], None],
    ) -> list[LossRow]:
        """Learn, and return the loss curve. Same arguments, same weights, also when killed and started again.

        `train` comes in parts, a shard each, and is gone through once. `checkpoints` is a folder for interrupted work, named by
        the caller after all inputs; `report` takes progress lines.
        """

    def sample(self, scenarios: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        """Motion (B, T) of the requests, T that of the longest scenario asked for; valid until each scenario's last step.

        Starts exactly in the initial state; never drives backward; parked vehicles stay exactly where they are.
        """

    def save(self, folder: Path) -> None:
        """Write settings (JSON) and weights (safetensors)."""

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read what `save` wrote. Raises MissingTool where there is nothing, UnusableInput where it does not fit."""
