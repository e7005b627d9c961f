"""Scenarios as padded arrays of vectors: what the learned generators see of a first frame, and what they learn from.

The input is the first frame only: vehicles, context actors, map and signals at step 0. `future` is of the log, for
training, and empty otherwise. Every padded size is a constant, so that a scenario's row depends on that scenario alone.
The frame of a scenario is that of its target at step 0: origin at its centre, x forward, y left.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import rotate, unit, wrap_angle
from drivegen.core.scenario import TARGET, Scenario, VehicleKind
from drivegen.generators.shared.motion import at_knots
from drivegen.generators.shared.pieces import FEATURES, POINTS, Pieces
from drivegen.store.columns import joined

AGENTS = 16
"""A, vehicles of a scenario at most: what `ingest.selection.max_vehicles` allows."""

PIECES = 256
"""M, pieces of the map at most: those nearest to where the vehicles are heading."""

ACTORS = 8
"""C, context actors at most: those nearest to the target."""

STEPS = 100
"""T, steps of the future, 10 s; a longer scenario is continued, a shorter one cut off."""

LOOK_AHEAD = 4.0
"""[s] Pieces are ranked by their distance from where a vehicle is, or will be after this time at its speed."""

AGENT_FEATURES = 3 + len(VehicleKind)
"""Speed [10 m/s], length and width [5 m], kind (one-hot)."""


@dataclass(frozen=True)
class Scenes:
    """S scenarios; rows beyond a mask are zero.

    Attributes:
        frame: (S, 3) float32 the target's x, y [m] and heading [rad] at step 0 in the map's frame.
        position: (S, A, 2) [m]. heading: (S, A) [rad]. speed: (S, A) [m/s]. agent: (S, A, AGENT_FEATURES).
        present: (S, A) bool which vehicles there are, in the scenario's order.
        points: (S, M, POINTS, 2) [m] pieces of centrelines. piece: (S, M, FEATURES), see `pieces.Pieces`. drawn: (S, M) bool.
        actor_position: (S, C, 2) [m]. actor_velocity: (S, C, 2) [m/s]. actor: (S, C, 2 + kinds) length and width [5 m],
            kind. seen: (S, C) bool.
        future: (S, A, T, 2) [m] logged positions at steps 1..T. future_heading: (S, A, T) [rad].
        logged: (S, A, T) bool where the log has them; T is 0 without logs.
    """

    frame: NDArray[np.float32]
    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    speed: NDArray[np.float32]
    agent: NDArray[np.float32]
    present: NDArray[np.bool_]
    points: NDArray[np.float32]
    piece: NDArray[np.float32]
    drawn: NDArray[np.bool_]
    actor_position: NDArray[np.float32]
    actor_velocity: NDArray[np.float32]
    actor: NDArray[np.float32]
    seen: NDArray[np.bool_]
    future: NDArray[np.float32]
    future_heading: NDArray[np.float32]
    logged: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.frame)

    @classmethod
    def empty(cls, count: int, steps: int) -> Self:
        """All zero and nothing there."""
        kinds = len(VehicleKind)
        shapes: dict[str, tuple[int, ...]] = {
            "frame": (3,), "position": (AGENTS, 2), "heading": (AGENTS,), "speed": (AGENTS,),
            "agent": (AGENTS, AGENT_FEATURES), "points": (PIECES, POINTS, 2), "piece": (PIECES, FEATURES),
            "actor_position": (ACTORS, 2), "actor_velocity": (ACTORS, 2), "actor": (ACTORS, 2 + kinds),
            "future": (AGENTS, steps, 2), "future_heading": (AGENTS, steps),
        }  # fmt: skip
        masks = {"present": (AGENTS,), "drawn": (PIECES,), "seen": (ACTORS,), "logged": (AGENTS, steps)}
        arrays: dict[str, Any] = {name: np.zeros((count, *shape), np.float32) for name, shape in shapes.items()}
        return cls(**arrays | {name: np.zeros((count, *shape), np.bool_) for name, shape in masks.items()})

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> Self:
        """First frames alone; the logs, if any, are not read.

        Raises UnusableInput for more vehicles than AGENTS.
        """
        made = cls.empty(len(scenarios), 0)
        pieces = Pieces.of(scenarios) if len(scenarios) else None
        for row, scenario in enumerate(scenarios):
            made._take_vehicles(row, scenario)
            made._take_actors(row, scenario)
            if pieces is not None:
                part = slice(pieces.start[row], pieces.start[row + 1])
                made._take_pieces(row, pieces.points[part], pieces.features[part])
        return made

    @classmethod
    def with_logs(cls, scenarios: Sequence[Scenario]) -> Self:
        """First frames and futures of the scenarios that have a log."""
        logged = [s for s in scenarios if s.log is not None]
        first, made = cls.of(logged), cls.empty(len(logged), STEPS)
        made = cls(**{f.name: getattr(made if f.name in _FUTURE else first, f.name) for f in fields(cls)})
        for row, scenario in enumerate(logged):
            made._take_future(row, scenario)
        return made

    @classmethod
    def none(cls) -> Self:
        """No scenario."""
        return cls.empty(0, STEPS)

    def __getitem__(self, index: slice | NDArray[np.integer]) -> Self:
        """The chosen scenarios."""
        return type(self)(**{f.name: getattr(self, f.name)[index] for f in fields(self)})

    def padded(self, count: int) -> Self:
        """With empty rows behind, `count` in all."""
        return joined(type(self), [self, self.empty(count - len(self), self.logged.shape[2])])

    def tensors(self, device: torch.device) -> "SceneTensors":
        """The same arrays as tensors on `device`."""
        return SceneTensors(**{f.name: torch.from_numpy(getattr(self, f.name)).to(device) for f in fields(self)})

    def _take_vehicles(self, row: int, scenario: Scenario) -> None:
        vehicles, count = scenario.vehicles, len(scenario.vehicles)
        if count > AGENTS:
            raise UnusableInput(
                f"scenario {scenario.scenario_id} has {count} vehicles; learned generators take {AGENTS}:"
                " lower ingest.selection.max_vehicles"
            )
        self.frame[row] = (*vehicles.position[TARGET], vehicles.heading[TARGET])
        self.position[row, :count] = self._local(row, vehicles.position)
        self.heading[row, :count] = wrap_angle(vehicles.heading - vehicles.heading[TARGET])
        self.speed[row, :count] = vehicles.speed
        self.agent[row, :count, 0] = vehicles.speed / 10.0
        self.agent[row, :count, 1:3] = vehicles.size[:, :2] / 5.0
        self.agent[row, :count, 3:] = np.eye(len(VehicleKind))[vehicles.kind]
        self.present[row, :count] = True

    def _take_actors(self, row: int, scenario: Scenario) -> None:
        context = scenario.context
        there = np.flatnonzero(context.motion.valid[:, 0])
        position = self._local(row, context.motion.position[there, 0])
        nearest = np.argsort(np.hypot(*position.T), kind="stable")[:ACTORS]
        count, chosen = len(nearest), there[nearest]
        self.actor_position[row, :count] = position[nearest]
        self.actor_velocity[row, :count] = rotate(context.motion.velocity[chosen, 0], -self.frame[row, 2])
        self.actor[row, :count, :2] = context.size[chosen, :2] / 5.0
        self.actor[row, :count, 2:] = np.eye(len(VehicleKind))[context.kind[chosen]]
        self.seen[row, :count] = True

    def _take_pieces(self, row: int, points: NDArray[np.float32], features: NDArray[np.float32]) -> None:
        local = self._local(row, points)
        here = self.position[row, self.present[row]]
        soon = here + unit(self.heading[row, self.present[row]]) * self.speed[row, self.present[row], None] * LOOK_AHEAD
        middle = local.mean(axis=1)
        gap = middle[:, None] - np.concatenate([here, soon])
        nearest = np.argsort((gap**2).sum(-1).min(axis=1), kind="stable")[:PIECES]
        count = len(nearest)
        self.points[row, :count] = local[nearest]
        self.piece[row, :count] = features[nearest]
        self.drawn[row, :count] = True

    def _take_future(self, row: int, scenario: Scenario) -> None:
        log = scenario.log
        assert log is not None
        count, steps = len(scenario.vehicles), min(STEPS, scenario.steps - 1)
        valid = log.valid[:, 1 : steps + 1]
        position = self._local(row, log.position[:, 1 : steps + 1])
        self.future[row, :count, :steps] = np.where(valid[..., None], position, 0)
        heading = wrap_angle(log.heading[:, 1 : steps + 1] - self.frame[row, 2])
        self.future_heading[row, :count, :steps] = np.where(valid, heading, 0)
        self.logged[row, :count, :steps] = valid

    def _local(self, row: int, points: NDArray[np.float32]) -> NDArray[np.float32]:
        """Points (..., 2) of the map's frame in the target's."""
        return rotate(points - self.frame[row, :2], -self.frame[row, 2])


_FUTURE = ("future", "future_heading", "logged")


@dataclass(frozen=True)
class SceneTensors:
    """`Scenes` on a device, attribute by attribute."""

    frame: Tensor
    position: Tensor
    heading: Tensor
    speed: Tensor
    agent: Tensor
    present: Tensor
    points: Tensor
    piece: Tensor
    drawn: Tensor
    actor_position: Tensor
    actor_velocity: Tensor
    actor: Tensor
    seen: Tensor
    future: Tensor
    future_heading: Tensor
    logged: Tensor

    def __len__(self) -> int:
        return len(self.frame)


def displacement(scenes: SceneTensors, knots: Tensor, futures: int) -> tuple[Tensor, Tensor]:
    """Mean displacement [m] of each future at the logged knots, and 1 where there are any, else 0.

    `knots` (S, ..., J, 2) in each vehicle's own frame; their dimension `futures`, 1 before the vehicles or 2 behind them, is that
    of the futures.
    """
    truth = at_knots(local_future(scenes)).unsqueeze(futures)
    logged = at_knots(scenes.logged[..., None])[..., 0].to(knots).unsqueeze(futures)
    gap = ((knots - truth) ** 2).sum(-1).add(1e-4).sqrt()
    steps = logged.sum(-1)
    return (gap * logged).sum(-1) / steps.clamp_min(1), (steps > 0).to(gap)


def local_future(scenes: SceneTensors) -> Tensor:
    """Logged positions (S, A, T, 2) [m] in each vehicle's own frame at step 0: x forward, y left."""
    gap = scenes.future - scenes.position[:, :, None]
    cos, sin = scenes.heading.cos()[:, :, None], scenes.heading.sin()[:, :, None]
    return torch.stack([cos * gap[..., 0] + sin * gap[..., 1], cos * gap[..., 1] - sin * gap[..., 0]], dim=-1)
