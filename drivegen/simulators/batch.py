"""The batch simulator: thousands of scenarios advance together, a step is a few tensor operations.

The world of `drivegen.world`, driven to the end. Scenarios run in chunks of fixed shape, padded, on any torch device; on one
device a result does not depend on who shares the batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.base import Driver, RuleDriver
from drivegen.drivers.shared.answer import checked
from drivegen.world.contact import outcome
from drivegen.world.ego import Ego
from drivegen.world.neighbours import Replayed
from drivegen.world.outcome import DrivingOutcome
from drivegen.world.paths import TargetPaths, target_paths
from drivegen.world.reactive import Reaction, Reactive
from drivegen.world.replay import Replay
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World

CHUNK = 512
"""Scenarios that advance together."""

_POSE = ("position", "heading", "speed")


class Plugin:
    """Batched closed loop on a torch device."""

    name = "batch"

    def __init__(
        self,
        device: str = "cpu",
        reaction: Reaction | None = None,
        to_target_alone: bool = False,
        counts_lights: bool = False,
    ) -> None:
        """`reaction`: how neighbours react, to everybody or `to_target_alone`; they are replayed without it.

        Red lights are counted where it `counts_lights`, which takes milliseconds a run.
        """
        self._device, self._reaction, self._to_target_alone = torch.device(device), reaction, to_target_alone
        self._counts_lights = counts_lights

    def run(
        self,
        driver: Driver,
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths | None = None,
        attacker: NDArray[np.integer] | None = None,
    ) -> DrivingOutcome:
        """See `base.Simulator.run`."""
        return self.run_each([driver], scenarios, traffic, paths, attacker)[0]

    def run_each(
        self,
        drivers: Sequence[Driver],
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths | None = None,
        attacker: NDArray[np.integer] | None = None,
    ) -> list[DrivingOutcome]:
        """As `run` for each of several drivers; scenes are packed once for all."""
        torch.set_num_threads(1)  # sums depend on the thread count
        attacker = np.zeros(len(scenarios), np.int64) if attacker is None else attacker
        paths = paths if paths is not None else target_paths(scenarios, traffic)
        steps = max(motion.steps for motion in traffic)
        parts = []  # a row a chunk, a column a driver
        for begin in range(0, len(scenarios), CHUNK):
            rows = slice(begin, begin + CHUNK)
            parts.append(self._run_chunk(drivers, scenarios[rows], traffic[rows], _rows(paths, rows), steps, attacker[rows]))
        return [DrivingOutcome.joined(column) for column in zip(*parts, strict=True)]

    def _run_chunk(
        self,
        drivers: Sequence[Driver],
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths,
        steps: int,
        attacker: NDArray[np.integer],
    ) -> list[DrivingOutcome]:
        scenes = Scenes.of(scenarios, traffic, paths, CHUNK, self._device)
        rules = any(map(looks, drivers))
        lookout = Lookout.of(scenes, scenarios, traffic, arrivals=rules) if rules or self._counts_lights else None
        return [self.drive(driver, scenes, scenarios, steps, attacker, lookout) for driver in drivers]

    def drive(
        self,
        driver: Driver,
        scenes: Scenes,
        scenarios: Sequence[Scenario],
        steps: int,
        attacker: NDArray[np.integer],
        lookout: Lookout | None,
    ) -> DrivingOutcome:
        """Drive through packed scenes, each once; beyond those of `scenarios` they are padding, of which nothing is said.

        `attacker` as in `run`; `lookout` is for a driver that `looks`, and to count red lights. Motion has so many `steps`.
        """
        rows = len(scenes)
        deaf = torch.zeros(rows, dtype=torch.int64)
        deaf[: len(attacker)] = torch.from_numpy(attacker.astype(np.int64))
        with torch.inference_mode():
            neighbours = (
                Reactive(scenes, rows, self._reaction, deaf, self._to_target_alone) if self._reaction else Replayed(scenes)
            )
            egos, met = _drive(driver, World(scenes, rows, neighbours, lookout if looks(driver) else None))
        others = _lived(scenes.replay, met)
        ended = _with_imposed(outcome(_trajectories(egos, others, steps), others, scenarios), met)
        return _with_red_lights(ended, egos, scenes, lookout) if lookout and self._counts_lights else ended


def looks(driver: Driver) -> bool:
    """Whether a driver wants to see rules."""
    return isinstance(driver, RuleDriver) and driver.sees_rules


@dataclass(frozen=True)
class _Met:
    """Reactive neighbours at one step, as in `Boxes` and `Reactive`, and their frame (S, 6, M)."""

    position: Tensor
    heading: Tensor
    valid: Tensor
    frame: Tensor
    hardest: Tensor
    taken: Tensor

    @classmethod
    def of(cls, world: World) -> "list[_Met]":
        """One of them; none of those that are replayed, who are known."""
        reactive = world.neighbours
        if not isinstance(reactive, Reactive):
            return []
        boxes = reactive.boxes(world)
        return [cls(boxes.position, boxes.heading, boxes.valid, reactive.seen(world)[0], reactive.hardest, reactive.taken)]


def _drive(driver: Driver, world: World) -> tuple[list[Ego], list[_Met]]:
    """The targets, and reactive neighbours, step by step."""
    egos, met = [world.ego], _Met.of(world)
    for _ in range(world.scenes.longest - 1):
        seen = world.observe()
        world.advance(checked(driver.act(seen), f"driver {driver.name}", seen.speed))
        egos.append(world.ego)
        met += _Met.of(world)
    return egos, met


def _lived(planned: Replay, met: list[_Met]) -> Replay:
    """The others as they moved."""
    names = ("position", "heading", "valid", "frame") if met else ()
    return replace(planned, **{name: torch.stack([getattr(m, name) for m in met], 1).cpu().numpy() for name in names})


def _with_imposed(ended: DrivingOutcome, met: list[_Met]) -> DrivingOutcome:
    """The outcome with what the targets imposed on reactive neighbours until their runs ended."""
    if not met:
        return ended
    rows, last = np.arange(len(ended.kind)), ended.motion.last_valid()
    braking, loss = (torch.stack([getattr(m, name) for m in met], 1).cpu().numpy() for name in ("hardest", "taken"))
    return replace(ended, imposed_braking=braking[rows, last], imposed_loss=loss[rows, last])


def _with_red_lights(ended: DrivingOutcome, egos: list[Ego], scenes: Scenes, lookout: Lookout) -> DrivingOutcome:
    """The outcome with the red lights that the targets came near and ran until their runs ended."""
    count = len(ended.kind)
    valid = torch.zeros((len(scenes), len(egos)), dtype=torch.bool)
    valid[:count] = torch.from_numpy(ended.motion.valid[:, : len(egos)])
    front = torch.stack([ego.along for ego in egos], 1) + 0.5 * scenes.size[:, :1]
    near, ran = (lights[:count].cpu().numpy().astype(np.float32) for lights in lookout.red_lights(front, valid.to(front.device)))
    return replace(ended, red_lights=near, red_run=ran)


def _trajectories(egos: list[Ego], others: Replay, steps: int) -> Trajectories:
    """The targets' motion (S, steps), valid for as long as their scenarios last; step 0 is their logged pose."""
    position, heading, speed = (torch.stack([getattr(ego, name) for ego in egos], 1).cpu().numpy() for name in _POSE)
    rows, done = speed.shape
    motion = Trajectories.empty(rows, steps)
    motion.position[:, :done], motion.heading[:, :done] = position, heading
    motion.position[:, 0], motion.heading[:, 0] = others.target_position, others.target_heading
    direction = np.stack([np.cos(motion.heading), np.sin(motion.heading)], axis=-1)
    motion.velocity[:, :done] = speed[..., None] * direction[:, :done]
    motion.valid[:] = np.arange(steps) < others.steps[:, None]
    return motion


def _rows(paths: TargetPaths, rows: slice) -> TargetPaths:
    return TargetPaths(paths.point[rows], paths.speed_limit[rows], paths.length[rows])
