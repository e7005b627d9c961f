"""R episodes side by side: actions in, observations, rewards and ends out. What every environment is made of.

An action is numbers in [-1, 1]: the first is the acceleration, 3 m/s2 times it where positive and 8 m/s2 times it where negative;
the second is the offset from the path, 1.5 m times it to the left (`path_offset`), or the angle of the front wheels, 0.6 rad
times it to the left (`free`). A step is 0.1 s. An episode is terminated by a collision, in free motion also off the road; it is
truncated at the end of its scenario and where the target leaves the map.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import DT
from drivegen.drivers.shared.conditions import MOTIONS, Rewards, Settings, Traffic
from drivegen.drivers.shared.features import COUNT, LIMIT, features
from drivegen.drivers.shared.network import on_path, pedals
from drivegen.world.bicycle import SHARPEST
from drivegen.world.ends import Surface, exits
from drivegen.world.neighbours import Replayed
from drivegen.world.observation import PATH_SPACING, Action, Observation, runs_red
from drivegen.world.outcome import ARTEFACTS
from drivegen.world.paths import route_paths
from drivegen.world.reactive import Reactive
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.touch import Moment, kinds, touched
from drivegen.world.world import World

OBSERVATION = Box(-LIMIT, LIMIT, (COUNT,), np.float32)
"""See `features` for each number and its unit."""

COMFORTABLE = 3.0
"""[m/s2] The acceleration whose square is the unit of discomfort."""

TERMS = tuple(field.name for field in fields(Rewards))


@dataclass(frozen=True)
class Step:
    """What came of one step of R episodes.

    Attributes:
        observation: (R, COUNT) as `drivers.shared.features` says. reward: (R,). terminated, truncated: (R,) bool.
        terms: (R, len(TERMS)) the reward's terms, weighted. kind: (R,) uint8 CollisionKind. off_road, left_map: (R,) bool.
    """

    observation: Tensor
    reward: Tensor
    terminated: Tensor
    truncated: Tensor
    terms: Tensor
    kind: Tensor
    off_road: Tensor
    left_map: Tensor


class Environment:
    """See the module.

    Attributes:
        traffic: the scenarios that may be played. playable: (P,) int64 those whose target overlaps nobody at step 0
            and is on the road.
        settings: what it is like. world: the R rows.
    """

    def __init__(self, traffic: Sequence[Traffic], rows: int, settings: Settings, device: str = "cpu") -> None:
        if not traffic:
            raise UnusableInput("an environment needs at least one scenario to drive in")
        torch.set_num_threads(1)  # tensors are small, and sums depend on the thread count
        self.traffic, self.settings, self._free = list(traffic), settings, settings.motion == "free"
        scenarios, motions = [s for s, _ in traffic], [m for _, m in traffic]
        paths = route_paths(scenarios, motions) if self._free else None
        self._scenes = Scenes.of(scenarios, motions, paths, device=device)
        self._lookout = Lookout.of(self._scenes, scenarios, motions) if settings.rules else None
        self._surface = Surface.of(scenarios, device) if self._free else None
        exit_known_to = PATH_SPACING if self._free else 0.0  # the road ends there: who leaves freely would be off it before
        self._exit = exits(self._scenes, scenarios) - exit_known_to
        self._done_to_it = torch.tensor(ARTEFACTS, dtype=torch.uint8, device=device)
        self._weights = torch.tensor([getattr(settings.rewards, name) for name in TERMS], device=device)
        with torch.no_grad():
            begin = self._world(len(traffic))
            view = begin.observe()
            self._first, self._first_line = features(view), view.red_line
            overlaps = touched(begin, begin.neighbours.boxes(begin))
            self.playable = torch.nonzero((overlaps < 0) & ~self._off_road(begin))[:, 0]
            if not len(self.playable):
                raise UnusableInput("in every scenario the target overlaps somebody at step 0, or is off the road")
            self.world = self._world(rows)
            self.reset(self.playable[torch.arange(rows, device=device) % len(self.playable)])

    @property
    def actions(self) -> Box:
        """Numbers in [-1, 1]; see the module for their units."""
        return Box(-1.0, 1.0, (MOTIONS[self.settings.motion],), np.float32)

    def draw_scenes(self, count: int, random: np.random.Generator) -> Tensor:
        """(count,) scenes to begin."""
        index = torch.from_numpy(random.integers(len(self.playable), size=count))
        return self.playable[index.to(self.playable.device)]

    def actions_of(self, numbers: Any) -> Tensor:
        """Actions of all rows as `step` takes them; of one number each they may come without their second dimension."""
        array = np.array(numbers, np.float32)
        return torch.from_numpy(array[:, None] if array.ndim == 1 else array).to(self.world.scene.device)

    @torch.no_grad()
    def reset(self, scene: Tensor, rows: Tensor | None = None) -> Tensor:
        """Begin `scene` in every row, or in `rows` alone; the first observations."""
        self.world.reset(scene, rows)
        if rows is None:
            self._line = self._first_line[scene]
        else:
            self._line[rows] = self._first_line[scene]
        self._last: Moment = self.world.ego, self.world.neighbours.boxes(self.world)
        return self._first[scene]

    @torch.no_grad()
    def step(self, action: Tensor) -> Step:
        """One step of all rows by actions (R, A) in [-1, 1]. Raises UnusableInput for another shape and for what is no number."""
        self._check(action)
        world, along, speed = self.world, self.world.ego.along, self.world.ego.speed
        world.advance(self._decoded(action.clamp(-1.0, 1.0)))
        view, boxes = world.observe(), world.neighbours.boxes(world)
        left_map = world.ego.along >= self._exit[world.scene]
        before, self._last = self._last, (world.ego, boxes)
        kind = kinds(world, touched(world, boxes).masked_fill(left_map, -1), before, self._last)
        off_road = self._off_road(world) & ~left_map
        terms = self._terms(view, world.ego.along - along, speed, kind, off_road) * self._weights
        terminated = (kind > 0) | off_road
        truncated = (world.over | left_map) & ~terminated
        return Step(features(view), terms.sum(1), terminated, truncated, terms, kind, off_road, left_map)

    def _check(self, action: Tensor) -> None:
        rows, numbers = len(self.world.scene), MOTIONS[self.settings.motion]
        if action.shape != (rows, numbers):
            raise UnusableInput(
                f"actions of motion {self.settings.motion!r} have the shape {(rows, numbers)}, not {tuple(action.shape)}"
            )
        if not action.isfinite().all():
            row = int(torch.nonzero(~action.isfinite().all(1))[0])
            raise UnusableInput(f"the action of row {row} is {action[row].tolist()}: give finite numbers from -1 to 1")

    def _world(self, rows: int) -> World:
        neighbours = (
            Reactive(self._scenes, rows, self.settings.reaction)
            if self.settings.neighbours == "reactive"
            else Replayed(self._scenes)
        )
        return World(self._scenes, rows, neighbours, self._lookout, free=self._free)

    def _decoded(self, action: Tensor) -> Action:
        return Action(pedals(action[:, 0]), steering=SHARPEST * action[:, 1]) if self._free else on_path(action)

    def _off_road(self, world: World) -> Tensor:
        if self._surface is None:
            return torch.zeros_like(world.scene, dtype=torch.bool)
        return self._surface.off_road(world.scene, world.ego.position, world.ego.heading, world.size)

    def _terms(self, view: Observation, moved: Tensor, speed: Tensor, kind: Tensor, off_road: Tensor) -> Tensor:
        """(R, len(TERMS)) what each weight is multiplied by."""
        hit = torch.isin(kind, self._done_to_it)
        red = runs_red(self._line, moved)
        self._line = view.red_line
        amounts = {
            "progress": moved,
            "comfort": ((view.speed - speed) / DT / COMFORTABLE) ** 2,
            "speeding": (view.speed - view.speed_limit).nan_to_num().clamp_min(0.0),
            "collision": (kind > 0) & ~hit,
            "hit": hit,
            "red": red,
            "off_road": off_road,
        }
        return torch.stack([amounts[name].float() for name in TERMS], 1)
