"""The world: R rows, each a scene with a clock of its own, advance together; a step is a few tensor operations."""

import torch
from torch import Tensor

from drivegen.world.bicycle import freely, placed
from drivegen.world.ego import Ego, on_path
from drivegen.world.neighbours import Neighbours, Replayed
from drivegen.world.observation import Action, Observation
from drivegen.world.rules import Lookout, Watch
from drivegen.world.scenes import Scenes


class World:
    """R rows, each in one of `scenes`; a row is a target that somebody drives, among neighbours.

    Attributes:
        scenes: what rows may show. scene, step: (R,) int64 the scene of each row, and the step that it is at.
        ego: Ego of the R targets. paths: Paths of theirs. size: (R, 2) [m] of theirs.
        neighbours: who moves the others.
    """

    def __init__(
        self,
        scenes: Scenes,
        rows: int,
        neighbours: Neighbours | None = None,
        lookout: Lookout | None = None,
        free: bool = False,
    ) -> None:
        """Without `neighbours` all are replayed, without a `lookout` no rules are seen; targets keep to paths or move `free`."""
        self.scenes, self.neighbours, self._free = scenes, neighbours or Replayed(scenes), free
        self._watch = Watch(lookout, rows) if lookout else None
        self._begin = Ego.at_start(scenes.speed, scenes.paths)  # of every scene: episodes begin in nearly every step
        if free:
            self._begin = placed(self._begin, *scenes.start, scenes.paths)
        self.scene = torch.arange(rows, device=scenes.steps.device) % len(scenes)
        self.reset(self.scene)

    def reset(self, scene: Tensor, rows: Tensor | None = None) -> None:
        """Begin `scene` in every row, or in `rows` alone."""
        ego = self._begin[scene]
        if rows is None:
            self.resume(scene, torch.zeros_like(scene), ego)
            return
        self.scene[rows], self.step[rows], self.size[rows] = scene, 0, self.scenes.size[scene]
        self.paths.put(rows, self.scenes.paths[scene])
        self.ego.put(rows, ego)
        self._reset_others(rows)

    def resume(self, scene: Tensor, step: Tensor, ego: Ego) -> None:
        """Go on in `scene` (R,) from `step` (R,) with `ego` as the targets; everybody else is where the scene has them then."""
        self.scene, self.step, self.ego = scene.clone(), step.clone(), ego
        self.size, self.paths = self.scenes.size[scene], self.scenes.paths[scene]
        self._reset_others(None)

    def _reset_others(self, rows: Tensor | None) -> None:
        self.neighbours.reset(self, rows)
        if self._watch:
            self._watch.reset(self, rows)

    @property
    def at(self) -> Tensor:
        """(R,) row of the tables of `Scenes` that shows each scene at its step; the last one after its end."""
        return self.scene * self.scenes.longest + self.step.clamp_max(self.scenes.longest - 1)

    @property
    def following(self) -> Tensor:
        """(R,) the row of the tables at the next step."""
        return self.scene * self.scenes.longest + (self.step + 1).clamp_max(self.scenes.longest - 1)

    @property
    def over(self) -> Tensor:
        """(R,) bool, whether the scene is at its last step."""
        return self.step >= self.scenes.steps[self.scene] - 1

    def observe(self) -> Observation:
        """What the drivers see; where they are and how fast is copied, so that no driver moves itself by changing it."""
        frame, present = self.neighbours.seen(self)
        place, left, half_length, half_width, speed_along, speed_across = frame.unbind(1)
        length, width = self.size.unbind(-1)
        ego, paths = self.ego, self.paths
        return Observation(
            step=self.step,
            along=ego.along.clone(),
            offset=ego.offset.clone(),
            course=ego.course.clone(),
            speed=ego.speed.clone(),
            length=length,
            width=width,
            speed_limit=paths.speed_limit.gather(1, paths.row((ego.along + 0.5 * length)[:, None]))[:, 0],
            ahead=place - ego.along[:, None],
            left=left,
            half_length=half_length,
            half_width=half_width,
            speed_along=speed_along,
            speed_across=speed_across,
            present=present,
            paths=paths,
            rules=self._watch.rules(self, frame) if self._watch else None,
        )

    def advance(self, action: Action) -> None:
        """One step of everybody; the neighbours decide before the targets have moved."""
        self.neighbours.advance(self)
        move = freely if self._free else on_path
        self.ego = move(self.ego, action, self.paths, self.size[:, 0])
        self.step = self.step + 1
