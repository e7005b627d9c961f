"""A generator's roll-outs on validation logs: few of them while it trains, all of them when it is trained."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import Count
from drivegen.core.twins import twin
from drivegen.generators.shared.learned import Learned
from drivegen.metrics.proper import mean_errors
from drivegen.roads.leaving import Exits
from drivegen.store.draw import draw_places
from drivegen.store.scenarios import read_shard, shards

WATCHED_SEED = 0
"""Of the scenes that are watched and of their futures, whatever is trained by whichever seed: so errors compare."""


@dataclass(frozen=True)
class Watched:
    """`scenes` validation scenarios with a log, every second one as its twin, and `samples` futures of each.

    So weights are kept that do with all layers and without, as the goal selector's are, whose lists hold both.
    """

    scenes: Count
    samples: Count

    def of(self, split: Path) -> list[Scenario]:
        """The scenes, the same for every generator; none where there is no split."""
        places = draw_places(WATCHED_SEED, split, self.scenes) if split.is_dir() else []
        read: dict[tuple[Path, int], Scenario] = {}
        for shard in {shard for shard, _ in places}:
            logs = read_shard(shard)
            read |= {(drawn, row): logs[row] for drawn, row in places if drawn == shard}
        scenes = [read[place] for place in places]
        return [twin(scene) if n % 2 else scene for n, scene in enumerate(scenes) if scene.log is not None]

    def errors(self, generator: Learned, scenes: Sequence[Scenario]) -> dict[str, float]:
        """Of its futures of these scenes, the same seeds whenever asked; see `metrics.proper.mean_errors`."""
        return mean_errors(rolled_out(generator, scenes, self.samples, WATCHED_SEED))


def rolled_out(
    generator: Learned, logged: Sequence[Scenario], samples: int, seed: int, told_log: bool = False
) -> Iterator[tuple[Trajectories, Trajectories]]:
    """Futures (K, N, T) of every scenario, which is `logged`, and its log (N, T); bounds are `told_log`.

    Who leaves the map is gone from then on, as in the futures that are judged.
    """
    shown = logged if told_log else [first_frame(scene) for scene in logged]
    for scene, futures in zip(logged, generator.generate(shown, samples, seed), strict=True):
        assert scene.log is not None
        yield Exits.of(scene.map).leave(futures.motion, scene.vehicles.size[:, 0]), scene.log


def scores_of(generator: Learned, split: Path, samples: int, seed: int, told_log: bool = False) -> dict[str, float]:
    """Errors [m] of `samples` futures of every scenario of a split, means over scenarios; shard by shard."""
    logs = ([scene for scene in read_shard(shard) if scene.log is not None] for shard in shards(split))
    return mean_errors(pair for part in logs for pair in rolled_out(generator, part, samples, seed, told_log))
