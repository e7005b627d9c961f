"""Grounds for attacks: a shard's scenarios, their recorded goals and their generated traffic, read side by side."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self, TypeVar

from drivegen.adversaries.shared.arena import Ground
from drivegen.adversaries.shared.ground import logged, sampled
from drivegen.checker.limits import Limits
from drivegen.checker.verdicts import read_limits
from drivegen.core.samples import Samples
from drivegen.planners.base import Planner
from drivegen.rollout.choices import Choices, recorded_choices
from drivegen.rollout.models import read_planner
from drivegen.store.goals import read_goals
from drivegen.store.lookup import evenly, shared
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import count, read_shard, shards
from stages._door import require

_Row = TypeVar("_Row", Choices, Samples)


@dataclass(frozen=True)
class Made:
    """Folders of shards that were made of a split, `goals` by one selector and `traffic`, and what made the traffic."""

    goals: Path
    traffic: Path
    planner: Planner
    limits: Limits

    @classmethod
    def open(cls, models: Path, planner: str, goals: Path, traffic: Path) -> Self:
        """Raises MissingTool, with the remedy, where a model is absent."""
        return cls(goals, traffic, read_planner(models, planner), read_limits(models))

    def choices(self, shard: Path) -> list[Choices]:
        """Every scenario of a shard of the split with its goals."""
        return recorded_choices(read_shard(shard), read_goals(require(self.goals / shard.name, "run the goals stage")), 1.0)

    def samples(self, shard: Path) -> list[Samples]:
        """The traffic of every scenario of that shard."""
        return read_samples(require(self.traffic / shard.name, "run the corner stage"))

    def ground(self, shard: Path, scenes: int, most: int) -> Ground:
        """The first `scenes` of each of at most so many scenarios, which are spread over the shard."""
        choices, samples = _spread(self.choices(shard), most), _spread(self.samples(shard), most)
        return sampled(choices, samples, scenes, self.planner, self.limits)

    def logs(self, shard: Path, most: int) -> Ground:
        """The logs of the same scenarios."""
        return logged(_spread(self.choices(shard), most), self.planner, self.limits)


def _spread(rows: "Sequence[_Row]", most: int) -> "list[_Row]":
    return [rows[r] for r in evenly(len(rows), most)]


def shares(split: Path, total: int) -> list[tuple[Path, int]]:
    """`total` shared out among the shards of a split by what each holds; none that gets nothing."""
    files = shards(require(split, "run the ingest stage"))
    parts = shared(total, [count(file) for file in files])
    return [(file, part) for file, part in zip(files, parts, strict=True) if part]
